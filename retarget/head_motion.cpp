#include "retarget/head_motion.h"

#include <algorithm>
#include <cmath>

namespace zygoma {

HeadMotion HeadMotion::operator*(const HeadMotion& second) const {
  HeadMotion result;
  result.a = a * second.a - b * second.b;
  result.b = b * second.a + a * second.b;
  result.shift = *this * second.shift;
  return result;
}

HeadMotion HeadMotion::inverse() const {
  const double square = a * a + b * b;
  HeadMotion result;
  result.a = a / square;
  result.b = -b / square;
  result.shift = {-(result.a * shift.x() - result.b * shift.y()),
                  -(result.b * shift.x() + result.a * shift.y())};
  return result;
}

double HeadMotion::scale() const { return std::hypot(a, b); }
double HeadMotion::roll_rad() const { return std::atan2(b, a); }

HeadMotion fit_head_motion(const NodeStack& from,
                           const NodeStack& to,
                           const Eigen::VectorXd& weight) {
  HeadMotion result;
  const double total = weight.sum();
  if (!(total > 0.0)) return result;
  const Point2 from_mean = from * weight / total;
  const Point2 to_mean = to * weight / total;
  double square = 0.0;
  double along = 0.0;
  double across = 0.0;
  for (int k = 0; k < kNumNodes; ++k) {
    if (weight[k] <= 0.0) continue;
    const Point2 p = from.col(k) - from_mean;
    const Point2 q = to.col(k) - to_mean;
    square += weight[k] * p.squaredNorm();
    along += weight[k] * p.dot(q);
    across += weight[k] * (p.x() * q.y() - p.y() * q.x());
  }
  if (square > 0.0 && std::hypot(along, across) > 1e-12 * square) {
    result.a = along / square;
    result.b = across / square;
  }
  result.shift = to_mean - Point2(result.a * from_mean.x() - result.b * from_mean.y(),
                                  result.b * from_mean.x() + result.a * from_mean.y());
  return result;
}

HeadMotion fit_head_motion_robustly(const NodeStack& from,
                                    const NodeStack& to,
                                    const Eigen::VectorXd& weight,
                                    double outlier_scale) {
  constexpr int kRounds = 12;
  HeadMotion fit = fit_head_motion(from, to, weight);
  for (int round = 0; round < kRounds; ++round) {
    // A wide loss first, so that one bad contour in the start does not freeze the fit on it.
    const double width = outlier_scale * std::max(1.0, 8.0 * std::pow(0.5, round));
    Eigen::VectorXd robust = weight;
    for (int k = 0; k < kNumNodes; ++k) {
      if (weight[k] <= 0.0) continue;
      const double distance = (fit * Point2(from.col(k)) - to.col(k)).norm() / width;
      robust[k] /= 1.0 + distance * distance;
    }
    fit = fit_head_motion(from, to, robust);
  }
  return fit;
}

Eigen::VectorXd head_weights(const StackedContours& neutral, const StackedContours& frame) {
  constexpr double kWeak = 0.05;  // evidence that moves with the expression as well
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(kNumNodes);
  const auto trust = [&](int contour) {
    const auto c = static_cast<std::size_t>(contour);
    return std::min(neutral.confidence[c], frame.confidence[c]);
  };
  // Corners of the eyes are points of the skull. Without them hairline and nose tip have to do,
  // though hair is hair and wings of a nose follow a smile.
  constexpr double kCorner = 4.0;
  double corners = 0.0;
  for (int contour = 0; contour < kNumContours; ++contour) {
    if (!is_eyelid(contour)) continue;
    weight[first_node(contour)] = weight[last_node(contour)] = kCorner * trust(contour);
    corners += kCorner * trust(contour);
  }
  const double rest = 9.0 / (1.0 + 2.0 * corners);
  for (const int contour : {kHairlineContour, kNoseTipContour}) {
    weight.segment(node_begin(contour), num_nodes(contour))
        .setConstant(trust(contour) * rest / num_nodes(contour));
  }
  for (const int contour : {kBrowLeftContour, kBrowRightContour}) {
    weight[last_node(contour)] = kWeak * trust(contour);
  }
  for (const int contour : {kFurrowLeftContour, kFurrowRightContour}) {
    weight[first_node(contour)] = kWeak * trust(contour);
  }
  weight[first_node(kUpperLipContour)] = weight[last_node(kUpperLipContour)] =
      kWeak * trust(kUpperLipContour);
  return weight;
}

}  // namespace zygoma
