// A stand-in face for tests of the tissue: a curved patch (the front of an ellipsoid) with a closed
// mouth slit, lip regions, a mandible below the mouth and the standard muscles. Exactly symmetric
// about x = 0. No head, no eyes, no lips: shape does not matter where it is used.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "face/anatomy.h"
#include "face/muscle_table.h"

namespace zygoma::test_support {

struct FacePatchOptions {
  int half_columns = 13;  // grid columns on each side of the middle, spaced by width / half_columns
  double width_mm = 65.0;  // of one side
  double row_mm = 7.0;
  int rows_below_mouth = 6;
  int rows_above_mouth = 20;
  double mouth_y_mm = -76.0;
  double mouth_half_mm = 29.0;  // grid points closer to the middle than this are slit open
  double depth_mm = 9.0;
};

inline Anatomy make_face_patch(const FacePatchOptions& o = {}) {
  Anatomy anatomy;
  const double step = o.width_mm / o.half_columns;
  const auto point = [&](int column, int row) -> Vec3 {
    const double x = column * step;
    const double y = o.mouth_y_mm + row * o.row_mm;
    const double inside = 1.0 - std::pow(x / 85.0, 2) - std::pow((y + 25.0) / 150.0, 2);
    return {x, y, 80.0 * std::sqrt(inside) - 80.0};
  };
  std::map<std::array<int, 3>, int> index;  // column, row, 1 = lower lip's copy
  const auto slit = [&](int column, int row) {
    return row == 0 && std::abs(column * step) < o.mouth_half_mm;
  };
  const auto vertex = [&](int column, int row, bool below) {
    const int copy = below && slit(column, row) ? 1 : 0;
    const auto [at, fresh] = index.try_emplace({column, row, copy}, 0);
    if (!fresh) return at->second;
    at->second = static_cast<int>(anatomy.surface.positions_mm.size());
    const Vec3 x = point(column, row);
    anatomy.surface.positions_mm.push_back(x);
    anatomy.tissue_depth_mm.push_back(o.depth_mm);
    const double off = std::abs(x.x());
    const bool lip = off < o.mouth_half_mm;
    Region region = Region::kFace;
    if (lip && copy == 0 && (row == 0 || row == 1)) region = Region::kUpperLip;
    if (lip && (copy == 1 || row == -1)) region = Region::kLowerLip;
    anatomy.region.push_back(region);
    double weight = 0.0;
    if (row < 0 || copy == 1) {
      const double opened = std::max(0.0, 1.0 - std::pow(off / (o.mouth_half_mm + 1.0), 2));
      const double side = std::clamp((off - 40.0) / 25.0, 0.0, 1.0);
      weight = std::clamp(-row * o.row_mm / 14.0 + opened, 0.0, 1.0) * (1.0 - side);
    }
    anatomy.mandible_weight.push_back(weight);
    return at->second;
  };
  for (int row = -o.rows_below_mouth; row < o.rows_above_mouth; ++row) {
    for (int column = -o.half_columns; column < o.half_columns; ++column) {
      const bool below = row < 0;
      const int a = vertex(column, row, below);
      const int b = vertex(column + 1, row, below);
      const int c = vertex(column + 1, row + 1, below);
      const int d = vertex(column, row + 1, below);
      if (column >= 0) {
        anatomy.surface.triangles.push_back({a, b, c});
        anatomy.surface.triangles.push_back({a, c, d});
      } else {
        anatomy.surface.triangles.push_back({a, b, d});
        anatomy.surface.triangles.push_back({b, c, d});
      }
    }
  }
  anatomy.muscles = standard_muscles(anatomy.surface, [](Vec2 p) { return p; });
  return anatomy;
}

inline std::shared_ptr<const Anatomy> shared_face_patch(const FacePatchOptions& o = {}) {
  return std::make_shared<const Anatomy>(make_face_patch(o));
}

// Index of the vertex nearest to a place, among those that pass the test.
template <typename Test>
int nearest_vertex(const Anatomy& anatomy, double x, double y, Test accept) {
  int best = -1;
  double best_distance = 1e30;
  for (std::size_t v = 0; v < anatomy.surface.positions_mm.size(); ++v) {
    const Vec3& p = anatomy.surface.positions_mm[v];
    const double distance = std::hypot(p.x() - x, p.y() - y);
    if (distance < best_distance && accept(static_cast<int>(v))) {
      best_distance = distance;
      best = static_cast<int>(v);
    }
  }
  return best;
}

}  // namespace zygoma::test_support
