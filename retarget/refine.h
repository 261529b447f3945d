// The contractions that explain all nodes of a frame, or of a window of frames, at once.
//
// With u the controls (muscles and jaw, in [0, 1]) and h the head (head_view.h; small, as a first
// guess of the head has been taken off), minimises over each frame
//
//   sum_k rho( || W_k ( p(n_k + d_k(u), h) - y_k ) ||^2 )
//     + ||(u + u_rest) / s_ridge||^2 + ||h / s_head||^2
//     + sum_antagonists (u_a u_b / s_antagonist)^2 + sum_tied ((u_a - u_b) / s_tie)^2
//
// where y_k is node k of the frame (mm of the model), n_k the same node at neutral, d the response
// of the face, and W_k whitens: its sigma is that of the contour, and a share of how far the node
// has gone, as no two faces move quite alike. Across the contour a node is known to that sigma,
// along it only weakly, as nothing in the image holds a node of a hairline or chin in place there.
// rho is Cauchy's loss. The priors are needed, not a matter of taste: nineteen controls from
// frontal contours are badly conditioned.
//
// A frame alone leans on the one before it, || (u - u_before) / s_time ||^2, which is all a live
// performance has. Frames of a file are solved together in windows, with their accelerations as
// one more residual, || u'' / s_acceleration ||^2: nothing lags.
//
// d may be corrected around a point for each frame (ModelCorrection): so the equilibrium of the
// lattice itself enters (lattice_loop.h).
//
// Derivatives are analytic; the posterior is (J^T J)^-1 with all priors at the solution, bounds
// ignored. A control with a posterior close to its prior was not observed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>

#include "retarget/frame_system.h"

namespace zygoma {

struct RefinedFrame {
  Eigen::VectorXd controls;
  HeadView::Parameters head = HeadView::Parameters::Zero();  // from the neutral head to the frame's
  bool converged = false;
  int iterations = 0;
  double cost = 0.0;        // of this frame alone, without time
  double optimality = 0.0;  // largest gradient left, of the controls that may still move along it
};

// What a solved frame says about itself.
struct FramePosterior {
  Eigen::VectorXd sigma;        // of the controls, from this frame and the priors
  Eigen::VectorXd prior_sigma;  // the same had there been no picture
  // How far a control moves when all nodes of a contour err by their sigma; controls x contours.
  Eigen::MatrixXd influence;
  std::array<double, kNumContours> residual_mm{};  // RMS over the nodes of used contours
};

class Refiner {
 public:
  // `response` is referred to, not copied.
  Refiner(const FaceResponse& response,
          const NodeStack& neutral_mm,
          double inverse_distance_per_mm = 0.0,
          const RefineOptions& options = {});
  ~Refiner();

  const RefineOptions& options() const;

  RefinedFrame refine(const FrameObservation& frame,
                      const RefinedFrame& start,
                      const ControlPrior& time);

  // Improves `solved` (same size as `frames`) together. The first `num_fixed` frames stay as they
  // are and only hand their motion on.
  void refine_window(std::span<const FrameObservation> frames,
                     std::span<RefinedFrame> solved,
                     int num_fixed);

  FramePosterior posterior(const FrameObservation& frame, const RefinedFrame& solved);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
