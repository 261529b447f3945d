// The jaw: a hinge through the condyles that also slides forward and down as it opens.
#pragma once

#include <Eigen/Geometry>

#include "face/geometry.h"

namespace zygoma {

struct Jaw {
  Vec3 condyle_axis_point_mm{0.0, -35.0, -85.0};  // midway between the condyles
  double full_rad = 0.35;                         // opening at jaw = 1
  double slide_mm_per_rad = 12.0;                 // forward and down along the articular eminence
};

// Rigid motion of the mandible at an opening; opening_rad > 0 moves the chin down and back.
// Identity at 0.
Eigen::Isometry3d open_from_closed(const Jaw& jaw, double opening_rad);

// d(position)/d(opening) of the point that is at `closed_mm` when the jaw is closed, mm per rad.
Vec3 opening_rate(const Jaw& jaw, double opening_rad, const Vec3& closed_mm);

}  // namespace zygoma
