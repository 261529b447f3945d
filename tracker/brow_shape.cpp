#include "tracker/brow_shape.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>

namespace zygoma {
namespace {

constexpr double kSlideShare = 0.8;  // of the flow along the brow that is believed
constexpr double kFarthestSlide = 3.0;
constexpr double kTiltRidge = 0.3;  // nodes' worth
constexpr double kBendRidge = 1.0;

// Height of the polyline at x, the nodes running either way; its end pieces go on straight.
double height_at(const std::vector<Point2>& line, double x) {
  const double sense = line.back().x() > line.front().x() ? 1.0 : -1.0;
  size_t piece = 0;
  while (piece + 2 < line.size() && sense * (x - line[piece + 1].x()) > 0.0) ++piece;
  const Point2 along = line[piece + 1] - line[piece];
  if (sense * along.x() < 1e-3) return line[piece].y();
  return line[piece].y() + along.y() * (x - line[piece].x()) / along.x();
}

}  // namespace

std::vector<Point2> as_brow_motion(const std::vector<Point2>& relaxed,
                                   const std::vector<Point2>& at_start,
                                   double slide_px) {
  assert(relaxed.size() == at_start.size() && relaxed.size() > 2);
  const double slide = std::clamp(kSlideShare * slide_px, -kFarthestSlide, kFarthestSlide);
  const double middle = 0.5 * (at_start.front().x() + at_start.back().x());
  const double half = 0.5 * (at_start.back().x() - at_start.front().x());
  const auto powers = [&](double x) {
    const double t = (x - middle) / half;
    return Eigen::Vector3d(1.0, t, t * t - 1.0 / 3.0);
  };
  Eigen::Matrix3d normal = Eigen::Vector3d(0.0, kTiltRidge, kBendRidge).asDiagonal();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Point2& p : relaxed) {
    const double x = p.x() - slide;
    const Eigen::Vector3d b = powers(x);
    normal += b * b.transpose();
    right += b * (p.y() - height_at(at_start, x));
  }
  const Eigen::Vector3d rise = normal.ldlt().solve(right);
  std::vector<Point2> brow = at_start;
  for (Point2& p : brow) p += Point2(slide, rise.dot(powers(p.x())));
  return brow;
}

}  // namespace zygoma
