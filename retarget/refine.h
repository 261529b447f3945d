// The contractions that explain all nodes of a frame at once.
//
// With u the controls (muscles and jaw, in [0, 1]), h = (a, b, t_x, t_y) a small correction of the
// head's similarity and w = (yaw, pitch) a small turn of the head out of the picture, minimises
//
//   sum_k rho( || W_k ( (1 + A(h)) y_k + t - n_k - d_k(u) - T_k w ) ||^2 )
//     + ||(u + u_rest) / s_ridge||^2 + ||(u - u_time) / s_time||^2 + ||(h, w) / s_head||^2
//     + sum_pairs (u_a u_b / s_pair)^2
//
// where y_k is node k of the frame (mm of the model, first guess of the head taken off), n_k the
// same node at neutral, d the response of the face, T_k the motion of the node under a turn, and
// W_k whitens: across the contour a node is known to its sigma, along it only weakly, as nothing in
// the image holds a node of a hairline or chin in place there. rho is Cauchy's loss. The priors
// are needed, not a matter of taste: eighteen muscles from frontal contours are badly conditioned.
//
// Derivatives are analytic; the posterior is (J^T J)^-1 with all priors at the solution, bounds
// ignored.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "retarget/head_motion.h"
#include "retarget/response.h"

namespace zygoma {

struct RefineOptions {
  double outlier_sigmas = 3.0;       // [1, 100]; small: strong expressions fade as outliers
  double ridge_sigma = 0.8;          // [0.05, 100]; small: everything shrinks towards rest
  double rest_pull = 0.15;           // [0, 1]; the ridge is centred this far below 0, so that small
                                     // contractions need evidence; large: weak expressions are lost
  double antagonist_sigma = 0.15;    // [0.01, 100]; small: brow raisers and lowerers exclude each
                                     // other even where the performer uses both
  double head_scale_sigma = 0.05;    // also of the roll, in rad; [1e-4, 1]
  double head_shift_sigma_mm = 5.0;  // [0.01, 100]
  double head_turn_sigma_rad = 0.1;  // yaw and pitch; [1e-4, 1]; large: turns explain expressions
  double independent_nodes = 3.0;    // how many of a contour's nodes err independently; [1, 9]
  int max_iterations = 40;           // over all rounds of the active set; [1, 1000]

  void check() const;
};

struct FrameObservation {
  NodeStack mm = NodeStack::Zero();
  std::array<double, kNumContours> sigma_mm{};  // 0: the contour is not used
};

// Gaussian belief about the controls from other instants; an infinite sigma says nothing.
struct ControlPrior {
  Eigen::VectorXd mean;
  double sigma = 0.0;
};

struct RefinedFrame {
  Eigen::VectorXd controls;
  Eigen::VectorXd sigma;  // posterior
  HeadMotion head;        // takes the frame's nodes (mm) on to the neutral head
  Eigen::Vector2d turn_rad{0.0, 0.0};
  std::array<double, kNumContours> residual_mm{};  // RMS over the nodes of used contours
  bool converged = false;
  int iterations = 0;
};

class Refiner {
 public:
  // `response` is referred to, not copied.
  Refiner(const FaceResponse& response,
          const NodeStack& neutral_mm,
          const RefineOptions& options = {});
  ~Refiner();

  RefinedFrame refine(const FrameObservation& frame,
                      const Eigen::VectorXd& start,
                      const ControlPrior& time);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
