#include "face/jaw.h"

namespace zygoma {
namespace {

// Along the articular eminence: forward and down, unit length.
const Vec3 kSlideDirection(0.0, -0.6, 0.8);

}  // namespace

Eigen::Isometry3d open_from_closed(const Jaw& jaw, double opening_rad) {
  if (opening_rad == 0.0) return Eigen::Isometry3d::Identity();
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(opening_rad, Vec3::UnitX()).toRotationMatrix();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = rotation;
  motion.translation() = jaw.condyle_axis_point_mm - rotation * jaw.condyle_axis_point_mm +
                         (jaw.slide_mm_per_rad * opening_rad) * kSlideDirection;
  return motion;
}

Vec3 opening_rate(const Jaw& jaw, double opening_rad, const Vec3& closed_mm) {
  const Vec3 arm = Eigen::AngleAxisd(opening_rad, Vec3::UnitX()).toRotationMatrix() *
                   (closed_mm - jaw.condyle_axis_point_mm);
  return Vec3::UnitX().cross(arm) + jaw.slide_mm_per_rad * kSlideDirection;
}

}  // namespace zygoma
