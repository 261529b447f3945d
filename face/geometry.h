// Points and triangle meshes of the face. Face frame: origin midway between the pupils, x to the
// subject's left, y up, z forward; millimetres.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace zygoma {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Triangle = std::array<int, 3>;  // counter-clockwise seen from outside

// 0 up to a, 1 from b on (or the other way round where b < a), smooth between.
inline double smooth_step(double a, double b, double t) {
  const double s = std::clamp((t - a) / (b - a), 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

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

// How many triangles there are at each edge, first < second.
inline std::map<std::array<int, 2>, int> edge_uses(const std::vector<Triangle>& triangles) {
  std::map<std::array<int, 2>, int> uses;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto [first, second] = std::minmax(t[k], t[(k + 1) % 3]);
      ++uses[{first, second}];
    }
  }
  return uses;
}

// Per vertex those it shares an edge or a triangle with, ascending.
template <std::size_t N>
std::vector<std::vector<int>> neighbors_by(const std::vector<std::array<int, N>>& cells,
                                           std::size_t num_vertices) {
  std::vector<std::vector<int>> neighbors(num_vertices);
  for (const std::array<int, N>& cell : cells) {
    for (const int a : cell) {
      for (const int b : cell) {
        if (a != b) neighbors[a].push_back(b);
      }
    }
  }
  for (std::vector<int>& around : neighbors) {
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
  }
  return neighbors;
}

}  // namespace zygoma
