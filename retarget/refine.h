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
#include <vector>

#include "retarget/head_view.h"
#include "retarget/response.h"

namespace zygoma {

struct RefineOptions {
  double outlier_sigmas = 3.0;       // [1, 1e6]; small: strong expressions fade as outliers; large:
                                     // plain least squares
  double ridge_sigma = 0.8;          // [0.05, 1e6]; small: everything shrinks towards rest
  double rest_pull = 0.15;           // [0, 1]; the ridge is centred this far below 0, so that small
                                     // contractions need evidence; large: weak expressions are lost
  double antagonist_sigma = 0.15;    // [0.01, 1e6]; small: raisers and lowerers exclude each other
                                     // even where the performer uses both
  double tie_sigma = 0.4;            // [0.01, 1e6]; of the middle frontalis to the inner one
  double head_scale_sigma = 0.05;    // also of the roll, in rad; [1e-4, 10]
  double head_shift_sigma_mm = 5.0;  // [0.01, 1000]
  double head_turn_sigma_rad = 0.03;  // yaw and pitch; [1e-4, 10]; large: turns explain expressions
  double relative_error = 0.25;       // [0, 10]; share by which one person's skin moves unlike
                                      // another's; small: large motions of skin the model does
                                      // not have pull at everything else
  double independent_nodes = 6.0;     // how many of a contour's nodes err independently; [1, 100]
  double fastest_per_s = 6.0;         // change of a contraction, one sigma; [0.1, 1e9]
  double acceleration_per_s2 = 60.0;  // in windows; [1, 1e9]
  double turn_acceleration_per_s2 = 4.0;  // of yaw and pitch, rad; [0.01, 1e9]
  int window_frames = 24;                 // solved together and kept; [1, 1000]
  int lookahead_frames = 8;  // solved with them and solved again in the next; [0, 1000]
  double tolerance = 1e-4;   // relative change of cost or controls that ends it, [1e-15, 0.1]
  int max_iterations = 40;   // over all rounds of the active set; [1, 1000]

  void check() const;
};

// What a better model of the face adds to the response around `at`:
// offset + slope (u - at). An empty slope is zero.
struct ModelCorrection {
  Eigen::VectorXd at;
  Eigen::VectorXd offset_mm;
  Eigen::MatrixXd slope_mm;
};

struct FrameObservation {
  double time_s = 0.0;
  NodeStack mm = NodeStack::Zero();
  std::array<double, kNumContours> sigma_mm{};  // 0: the contour is not used
  const ModelCorrection* correction = nullptr;
};

// Gaussian belief about the controls from the instant before; an infinite sigma says nothing.
struct ControlPrior {
  Eigen::VectorXd mean;
  double sigma = 0.0;
};

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
