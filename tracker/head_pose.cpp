#include "tracker/head_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "tracker/face_chart.h"
#include "tracker/robust.h"

namespace zygoma {
namespace {

constexpr int kRounds = 6;
constexpr double kNoise = 0.25;    // chart px: smaller errors all count as good
constexpr double kUsualYaw = 0.4;  // rad, spread of the prior
// Lids, nostrils and the tip of the nose go up and down with the expression as well, so pitch is
// believed about half: the prior weighs as much as the points do, chart px^2 per rad^2.
constexpr double kPitchDoubt = 2000.0;
constexpr double kFarthestTurn = 0.7;  // rad: beyond it half of the face is hidden

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Point2 predicted(const Similarity& s, const HeadTurn& turn, const RigidPoint& point) {
  return s.apply(turn.apply(point.position, point.depth));
}

// One Gauss-Newton step in (a, b, shift, yaw, pitch).
bool step(const std::vector<RigidPoint>& points,
          const std::vector<Point2>& to,
          const std::vector<double>& weight,
          Similarity& s,
          HeadTurn& turn) {
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    const Point2 p = points[i].position - kChartEyeMiddle;
    const double z = points[i].depth;
    const double cy = std::cos(turn.yaw_rad), sy = std::sin(turn.yaw_rad);
    const double cp = std::cos(turn.pitch_rad), sp = std::sin(turn.pitch_rad);
    const Point2 seen = turn.apply(points[i].position, z);
    const double towards = z * cy - p.x() * sy;
    const Point2 by_yaw(-p.x() * sy + z * cy, (z * sy + p.x() * cy) * sp);
    const Point2 by_pitch(0.0, -p.y() * sp - towards * cp);
    Eigen::Matrix<double, 2, 6> j;
    j << seen.x(), -seen.y(), 1.0, 0.0, s.a * by_yaw.x() - s.b * by_yaw.y(),
        s.a * by_pitch.x() - s.b * by_pitch.y(),  //
        seen.y(), seen.x(), 0.0, 1.0, s.b * by_yaw.x() + s.a * by_yaw.y(),
        s.b * by_pitch.x() + s.a * by_pitch.y();
    normal += weight[i] * j.transpose() * j;
    right += weight[i] * j.transpose() * (to[i] - s.apply(seen));
  }
  const double yaw_prior = kNoise * kNoise / (kUsualYaw * kUsualYaw);
  normal(4, 4) += yaw_prior;
  normal(5, 5) += kPitchDoubt;
  right(5) -= kPitchDoubt * turn.pitch_rad;
  right(4) -= yaw_prior * turn.yaw_rad;

  const Eigen::LDLT<Matrix6> factor(normal);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0)) return false;
  const Vector6 change = factor.solve(right);
  if (!change.allFinite()) return false;
  s.a += change(0);
  s.b += change(1);
  s.shift += Point2(change(2), change(3));
  const auto limited = [](double rad) { return std::clamp(rad, -kFarthestTurn, kFarthestTurn); };
  turn = {limited(turn.yaw_rad + change(4)), limited(turn.pitch_rad + change(5))};
  return true;
}

}  // namespace

Point2 HeadTurn::apply(const Point2& straight, double depth) const {
  const Point2 p = straight - kChartEyeMiddle;
  const double towards = depth * std::cos(yaw_rad) - p.x() * std::sin(yaw_rad);
  return kChartEyeMiddle + Point2(p.x() * std::cos(yaw_rad) + depth * std::sin(yaw_rad),
                                  p.y() * std::cos(pitch_rad) - towards * std::sin(pitch_rad));
}

HeadPoseFit fit_head_pose(const std::vector<RigidPoint>& points,
                          const std::vector<Point2>& to,
                          const HeadTurn& last) {
  assert(points.size() == to.size());
  HeadPoseFit fit;
  fit.turn = last;
  std::vector<Point2> seen;
  seen.reserve(points.size());
  for (const RigidPoint& point : points) seen.push_back(last.apply(point.position, point.depth));
  const HeadFrameFit start = fit_head_frame(seen, to);
  if (!start.ok) return fit;
  fit.similarity = start.similarity;
  std::vector<double> errors(points.size());
  std::vector<double> weight(points.size());
  double limit = 0.0;
  for (int round = 0; round <= kRounds; ++round) {
    for (size_t i = 0; i < points.size(); ++i) {
      errors[i] = (predicted(fit.similarity, fit.turn, points[i]) - to[i]).squaredNorm();
    }
    limit = tukey_weights(errors, kNoise, weight);
    if (round < kRounds && !step(points, to, weight, fit.similarity, fit.turn)) return fit;
  }
  const auto inliers = std::count_if(
      errors.begin(), errors.end(), [&](double error) { return error < limit * limit; });
  fit.inlier_share = static_cast<double>(inliers) / static_cast<double>(points.size());
  const double scale = fit.similarity.scale();
  fit.ok = inliers >= 8 && std::isfinite(scale) && scale > 0.5 && scale < 2.0;
  return fit;
}

}  // namespace zygoma
