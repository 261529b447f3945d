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

struct SurfaceMesh {
  std::vector<Vec3> positions_mm;
  std::vector<Triangle> triangles;
};

}  // namespace zygoma
