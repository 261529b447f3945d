// One performer on one face: what calibration found, and the estimation of frame after frame with
// it. next() is causal and is all a live performance needs; improve() solves a stretch of frames
// once more, together, for files.
#pragma once

#include <memory>
#include <span>

#include "retarget/retarget.h"

namespace zygoma {

struct Calibration {
  Neutral neutral;
  PerformerFrame performer;
  Eigen::VectorXd gain;  // range of motion, multiples of the model's
  FaceResponse model;    // at the level asked for, scaled by the gain
  double jaw_carry = 1.0;
  FaceResponse response;  // the model with that carry
  Point2 head_reference_mm{0.0, 0.0};
};

Calibration calibrate(const Neutral& neutral,
                      const Eigen::VectorXd& gain,
                      const FaceResponse& response,
                      FaceLevel level);

// The state of one frame between the passes.
struct FrameEstimate {
  StackedContours seen;
  FrameReading reading;
  RefinedFrame refined;
  ModelCorrection correction;  // of the lattice; empty without
  FramePosterior posterior;
};

// The same performer with a carry of the jaw that is one step closer to what single frames show,
// which were estimated with `calibration`.
Calibration learn(const Calibration& calibration,
                  std::span<const FrameEstimate> sample,
                  const RetargetOptions& options);

class FrameEstimator {
 public:
  // Refers to the calibration and, for FaceLevel::kLattice, to the lattice of its face.
  FrameEstimator(const Calibration& calibration,
                 const RetargetOptions& options,
                 Simulator* lattice);

  // Head frame out, the paper's estimates, refinement from there, leaning on the frame before.
  FrameEstimate next(const ObservedFrame& frame);

  // Refines frames again, all together; the first `num_fixed` only hand their motion on.
  void improve(std::span<FrameEstimate> estimates, int num_fixed);

  // Uncertainty and residuals at the present estimate.
  void judge(FrameEstimate& estimate);

  LatticeLoopFigures lattice_figures() const;

 private:
  RefinedFrame refine(FrameEstimate& estimate, const RefinedFrame& start, const ControlPrior& time);

  const Calibration& calibration_;
  RetargetOptions options_;
  Refiner refiner_;
  std::unique_ptr<Refiner> first_pass_;  // where improve() follows: quicker, rougher
  std::unique_ptr<LatticeLoop> loop_;
  bool has_last_ = false;
  double last_time_s_ = 0.0;
  RefinedFrame last_;
  ModelCorrection last_correction_;
};

// The result of a frame as it is exported; sigma and residuals from its posterior.
Contractions contractions_of(const FrameEstimate& estimate, const Calibration& calibration);

// Errors of a contour persist, so neighbours in time are no further measurement; but what was known
// a moment ago is still known a little less well: sigma may be no larger than that of a neighbour
// and the change meanwhile together. Both ways in time, or forwards only.
void carry_sigma(std::span<FrameEstimate> estimates,
                 const Eigen::VectorXd& fastest_per_s,
                 bool causal);

}  // namespace zygoma
