// Points and triangle meshes of the face. Face frame: origin midway between the pupils, x to the
// subject's left, y up, z forward; millimetres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace zygoma {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Triangle = std::array<int, 3>;  // counter-clockwise seen from outside

// k x v as a matrix times v.
inline Eigen::Matrix3d cross_matrix(const Vec3& k) {
  Eigen::Matrix3d m;
  m << 0.0, -k.z(), k.y(), k.z(), 0.0, -k.x(), -k.y(), k.x(), 0.0;
  return m;
}

struct SurfaceMesh {
  std::vector<Vec3> positions_mm;
  std::vector<Triangle> triangles;
};

}  // namespace zygoma
