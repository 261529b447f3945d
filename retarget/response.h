// What the face model's contours do when it is told to contract: the map that the estimation
// inverts, baked so that a frame costs microseconds and not an equilibrium.
//
// The named curves of the anatomy, projected frontally (x to the image's right, y down, mm at the
// depth of the pupils) and resampled to the schema's nodes, move with the controls u = (c_1 .. c_M,
// jaw), all in [0, 1], by
//
//   d(u) = sum_i (l_i u_i + q_i u_i^2 + r_i u_i^3) + sum_(a,b) x_ab u_a u_b.
//
// l is the exact sensitivity of the equilibrium at rest, q and r the saturation read from settled
// half and full contractions (and the curved path of the jaw), x_ab the pairwise correctives: how
// the sensitivity to one control changes under another. linearised() keeps the chord to half
// strength alone.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "retarget/correspondence.h"

namespace zygoma {

// The muscles that contours can tell apart, in their order; all others stay slack when a
// performance is read. The rings of the mouth, the orbital ring of the eyes, and muscles that lie
// side by side with one of these would only share its evidence. Of the lids, the palpebral part of
// orbicularis oculi closes and the levator opens wider.
const std::vector<std::string>& observable_muscles();
bool moves_lid(std::string_view muscle);

struct FaceResponse {
  std::vector<std::string> muscles;
  NodeStack rest_mm = NodeStack::Zero();
  Eigen::VectorXd rest_depth_mm = Eigen::VectorXd::Zero(kNumNodes);  // towards the viewer
  std::array<bool, kNumContours> has_contour{};
  double viewing_distance_mm = 900.0;  // at which it was measured

  // Rows 2 node + axis, one column per muscle and a last one for the jaw.
  Eigen::MatrixXd linear_mm;
  Eigen::MatrixXd quadratic_mm;
  Eigen::MatrixXd cubic_mm;
  std::vector<std::pair<int, int>> pairs;  // of controls, the first below the second
  Eigen::MatrixXd pair_mm;                 // one column per pair

  int settles_not_converged =
      0;  // while it was built; a derivative at no strict minimum counts too

  int num_muscles() const { return static_cast<int>(muscles.size()); }
  int num_controls() const { return num_muscles() + 1; }

  // Zero response of the right size, for a face of these muscles.
  static FaceResponse zero(const std::vector<std::string>& muscles);

  // The same face without saturation and correctives.
  FaceResponse linearised() const;

  // A performer whose strongest contractions are gain[i] times those of the model (controls in the
  // order of u).
  FaceResponse scaled(const Eigen::VectorXd& gain) const;

  // Displacements of all nodes (2 node + axis) under the controls and, where asked for, their
  // derivative (one column per control).
  void displace(const Eigen::VectorXd& controls,
                Eigen::VectorXd& displacement_mm,
                Eigen::MatrixXd* slope_mm = nullptr) const;

  // Of one node.
  Point2 displacement(int node, const double* controls) const;
};

}  // namespace zygoma
