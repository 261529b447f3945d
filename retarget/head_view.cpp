#include "retarget/head_view.h"

#include <algorithm>
#include <cmath>

namespace zygoma {

HeadView::HeadView(const Parameters& head, double inverse_distance_per_mm)
    : inverse_distance_(inverse_distance_per_mm),
      scale_(std::exp(head[0])),
      shift_(head[2], head[3]),
      cos_yaw_(std::cos(head[4])),
      sin_yaw_(std::sin(head[4])),
      cos_pitch_(std::cos(head[5])),
      sin_pitch_(std::sin(head[5])) {
  roll_ << std::cos(head[1]), -std::sin(head[1]), std::sin(head[1]), std::cos(head[1]);
}

HeadView::Sight HeadView::see(const Point2& q, double depth_mm) const {
  // Beyond this the camera is inside the head; no frame of a face gets there.
  constexpr double kNearest = 0.8;
  const double k = inverse_distance_;
  const double z = depth_mm;
  const double shrink = 1.0 - std::min(kNearest, k * z);
  const double cp = cos_yaw_;
  const double sp = sin_yaw_;
  const double ct = cos_pitch_;
  const double st = sin_pitch_;

  const double x = shrink * q.x();
  const double y = shrink * q.y();
  const double y1 = y * ct + z * st;
  const double z1 = z * ct - y * st;
  const double x1 = x * cp + z1 * sp;
  const double z2 = z1 * cp - x * sp;
  const double near = std::min(kNearest, k * scale_ * z2);
  const double m = scale_ / (1.0 - near);
  // dm/dz2, dm/ds
  const double m_by_z = m * k * scale_ / (1.0 - near);
  const double m_by_s = m + m * near / (1.0 - near);

  const Point2 flat = roll_ * Point2(x1, y1);
  Sight sight;
  sight.at = m * flat + shift_;

  // (x1, y1, z2) by (x, y).
  Eigen::Matrix2d flat_by_xy;  // (x1, y1)
  flat_by_xy << cp, -st * sp, 0.0, ct;
  const Eigen::RowVector2d z_by_xy(-sp, -st * cp);
  sight.by_node = shrink * (m * roll_ * flat_by_xy + m_by_z * flat * z_by_xy);

  sight.by_head.col(0) = m_by_s * flat;
  sight.by_head.col(1) = m * Point2(-flat.y(), flat.x());
  sight.by_head.col(2) = Point2(1.0, 0.0);
  sight.by_head.col(3) = Point2(0.0, 1.0);
  // d(x1, y1, z2)/d psi = (z2, 0, -x1); d/d theta = (-y1 sp, z1, -y1 cp).
  sight.by_head.col(4) = m * roll_ * Point2(z2, 0.0) - m_by_z * x1 * flat;
  sight.by_head.col(5) = m * roll_ * Point2(-y1 * sp, z1) - m_by_z * y1 * cp * flat;
  return sight;
}

HeadMotion similarity_of(const HeadView::Parameters& head) {
  HeadMotion motion;
  const double scale = std::exp(head[0]);
  motion.a = scale * std::cos(head[1]);
  motion.b = scale * std::sin(head[1]);
  motion.shift = {head[2], head[3]};
  return motion;
}

}  // namespace zygoma
