// The curves of the anatomy as the contours of a picture: projected frontally with perspective and
// resampled to the schema's nodes, in any state of the face, and how they follow the controls
// there.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "face/simulator.h"
#include "retarget/correspondence.h"

namespace zygoma {

using CurvePoints = std::array<std::vector<Vec3>, kNumContours>;

class CurveProbe {
 public:
  // Refers to the anatomy. Names of curves that the schema lacks are ignored, and the other way
  // round.
  CurveProbe(const Anatomy& anatomy, double viewing_distance_mm);

  bool has(int contour) const { return !vertices_[static_cast<std::size_t>(contour)].empty(); }

  // The stack of nodes in the image, mm at the depth of the pupils.
  NodeStack image(const FaceState& state) const;

  // Depth of the nodes, by linear interpolation over the same arc length.
  Eigen::VectorXd depth(const FaceState& state) const;

  // d(stack)/d(controls) at an equilibrium, for these muscles of the anatomy and, last, the jaw per
  // unit of its full opening; rows 2 node + axis. `damped`: the state is no strict minimum, and the
  // derivatives are too small.
  Eigen::MatrixXd sensitivity(Simulator& face,
                              const std::vector<int>& muscles,
                              const Controls& controls,
                              const FaceState& state,
                              bool& damped) const;

 private:
  CurvePoints curves(const FaceState& state) const;
  CurvePoints velocities(const Eigen::Ref<const Eigen::VectorXd>& column) const;
  void project(const CurvePoints& points,
               const CurvePoints& velocity,
               NodeStack& nodes_mm,
               NodeStack& node_velocity) const;
  template <typename Visit>
  void for_each_support(int vertex, Visit&& visit) const;

  const Anatomy& anatomy_;
  double distance_mm_;
  std::array<std::vector<int>, kNumContours> vertices_;
};

// Nodes as one column, 2 node + axis.
inline Eigen::VectorXd flatten(const NodeStack& nodes) {
  return Eigen::Map<const Eigen::VectorXd>(nodes.data(), nodes.size());
}

}  // namespace zygoma
