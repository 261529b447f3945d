// The lattice itself inside the loop: the third level of the face model, after the linear response
// and the response with correctives.
//
// A frame's model is the response plus what the equilibrium under the present controls u0 adds to
// it, to first order exact:
//
//   d(u) = d_response(u) + [d_lattice(u0) - d_response(u0)] + [J_lattice - J_response] (u - u0)
//
// The refinement runs on this sum (refine.h, Ceres), u0 moves to its result, and so on:
// Gauss-Newton steps whose fixed point is that of the lattice, with the curvature of the response
// for free. Each round costs one settle, warm from where the tissue already is; the sensitivities
// of the equilibrium, dear against that, are taken anew only where the controls have gone far from
// where they were last taken.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "face/simulator.h"
#include "retarget/curve_probe.h"
#include "retarget/refine.h"

namespace zygoma {

struct LatticeLoopOptions {
  int max_rounds = 6;             // of settle and refine per frame, [1, 100]
  double tolerance = 5e-3;        // done when no control changes more, [1e-9, 1]
  double refresh_distance = 0.2;  // change of a control that asks for new sensitivities, [0, 1]

  void check() const;
};

struct LatticeLoopFigures {
  int settles = 0;
  int settles_not_converged = 0;
  int sensitivities = 0;
};

class LatticeLoop {
 public:
  // `response` is this face's, scaled by `gain`; the refiner runs on it or on what a performer adds
  // to it. Refers to both.
  LatticeLoop(Simulator& face,
              const FaceResponse& response,
              const Eigen::VectorXd& gain,
              const LatticeLoopOptions& options = {});

  // Makes `correction` that of the lattice at these controls. False, and the correction as it was,
  // if there is no equilibrium.
  bool correct(const Eigen::VectorXd& controls, ModelCorrection& correction);

  // Whether the controls have moved on from where the correction is exact.
  bool has_moved(const ModelCorrection& correction, const Eigen::VectorXd& controls) const;

  const LatticeLoopOptions& options() const { return options_; }
  const LatticeLoopFigures& figures() const { return figures_; }

 private:
  Simulator& face_;
  const FaceResponse& response_;
  Eigen::VectorXd gain_;
  LatticeLoopOptions options_;
  LatticeLoopFigures figures_;
  CurveProbe probe_;
  std::vector<int> muscle_;  // of the anatomy, per muscle of the response
  Eigen::VectorXd rest_mm_;
  FaceState state_;
  Eigen::VectorXd slope_at_;  // where the sensitivities were taken; empty: nowhere yet
  Eigen::MatrixXd extra_slope_;
};

}  // namespace zygoma
