// What the face model's contours do when it is told to contract: the map that the estimation
// inverts.
//
// The named curves of the anatomy, projected frontally (x to the image's right, y down, mm at the
// depth of the pupils) and resampled to the schema's nodes, move with the controls u = (c_1 .. c_M,
// jaw), all in [0, 1], by
//
//   d(u) = sum_i (l_i u_i + q_i u_i^2) + r j^3 + j sum_i x_i u_i,       j = jaw.
//
// l is the exact sensitivity of the equilibrium at rest, q the saturation read from settled full
// contractions, r the curved path of the jaw, x the change of the sensitivities under the open jaw.
// One evaluation is a few thousand multiplications, so that a frame costs a millisecond and not an
// equilibrium.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "retarget/correspondence.h"

namespace zygoma {

// The muscles that nine contours can tell apart, in their order; all others stay slack when a
// performance is read. Lids, the rings of mouth and eyes, and muscles that lie side by side with
// one of these would only share its evidence.
const std::vector<std::string>& observable_muscles();

struct FaceResponse {
  std::vector<std::string> muscles;
  NodeStack rest_mm = NodeStack::Zero();
  Eigen::VectorXd rest_depth_mm = Eigen::VectorXd::Zero(kNumNodes);  // towards the viewer
  std::array<bool, kNumContours> has_contour{};
  double viewing_distance_mm = 900.0;

  // Rows 2 node + axis, one column per muscle and a last one for the jaw.
  Eigen::MatrixXd linear_mm;
  Eigen::MatrixXd quadratic_mm;
  Eigen::VectorXd jaw_cubic_mm;
  Eigen::MatrixXd jaw_cross_mm;  // one column per muscle

  int settles_not_converged =
      0;  // while it was built; a derivative at no strict minimum counts too

  int num_muscles() const { return static_cast<int>(muscles.size()); }
  int num_controls() const { return num_muscles() + 1; }

  // Zero response of the right size, for a face of these muscles.
  static FaceResponse zero(const std::vector<std::string>& muscles);

  // Displacement of one node under the controls and, where asked for, its derivative (2 rows of
  // num_controls() each).
  Point2 displacement(int node,
                      const double* controls,
                      Eigen::Matrix<double, 2, Eigen::Dynamic>* jacobian = nullptr) const;

  // First-order motion of a node's image under a turn (yaw: the face turns to the image's right)
  // and a nod (pitch: the face turns downwards) of one radian.
  Point2 yaw_motion(int node) const;
  Point2 pitch_motion(int node) const;
};

}  // namespace zygoma
