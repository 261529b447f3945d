#include "tracker/head_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "tracker/robust.h"

namespace zygoma {
namespace {

constexpr int kRounds = 6;
constexpr double kMinPairSeparation = 4.0;  // px, else a pair says nothing about scale and roll

double squared_error(const Similarity& s, const Point2& from, const Point2& to) {
  return (s.apply(from) - to).squaredNorm();
}

// Weighted least squares, closed form about the weighted means.
bool least_squares(const std::vector<Point2>& from,
                   const std::vector<Point2>& to,
                   const std::vector<double>& weight,
                   Similarity& out) {
  double sum = 0.0;
  Point2 mean_from = Point2::Zero();
  Point2 mean_to = Point2::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    sum += weight[i];
    mean_from += weight[i] * from[i];
    mean_to += weight[i] * to[i];
  }
  if (sum <= 0.0) return false;
  mean_from /= sum;
  mean_to /= sum;
  double dot = 0.0;
  double cross = 0.0;
  double spread = 0.0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Point2 u = from[i] - mean_from;
    const Point2 v = to[i] - mean_to;
    dot += weight[i] * u.dot(v);
    cross += weight[i] * (u.x() * v.y() - u.y() * v.x());
    spread += weight[i] * u.squaredNorm();
  }
  if (spread < 1e-9 * sum) return false;
  out.a = dot / spread;
  out.b = cross / spread;
  out.shift = Point2::Zero();
  out.shift = mean_to - out.apply(mean_from);
  return true;
}

Similarity best_pair(const std::vector<Point2>& from, const std::vector<Point2>& to) {
  Similarity best;
  double best_median = std::numeric_limits<double>::infinity();
  std::vector<double> errors(from.size());
  // Every pair of a set thinned to about 12 points: a bounded, repeatable search.
  const size_t stride = std::max<size_t>(1, from.size() / 12);
  for (size_t i = 0; i < from.size(); i += stride) {
    for (size_t j = i + stride; j < from.size(); j += stride) {
      if ((from[i] - from[j]).norm() < kMinPairSeparation) continue;
      const Similarity s = similarity_from_pair(from[i], from[j], to[i], to[j]);
      size_t num_better = 0;
      for (size_t k = 0; k < from.size(); ++k) {
        errors[k] = squared_error(s, from[k], to[k]);
        num_better += errors[k] < best_median ? 1 : 0;
      }
      if (num_better <= from.size() / 2) continue;  // its median is no better: no need to find it
      best_median = median(errors);
      best = s;
    }
  }
  return best;
}

}  // namespace

double Similarity::scale() const { return std::hypot(a, b); }

Similarity Similarity::inverse() const {
  const double square = a * a + b * b;
  Similarity out{a / square, -b / square, Point2::Zero()};
  out.shift = -out.apply(shift);
  return out;
}

Similarity Similarity::after(const Similarity& inner) const {
  return {a * inner.a - b * inner.b, a * inner.b + b * inner.a, apply(inner.shift)};
}

Similarity similarity_from_pair(const Point2& from_a,
                                const Point2& from_b,
                                const Point2& to_a,
                                const Point2& to_b) {
  const Point2 u = from_b - from_a;
  const Point2 v = to_b - to_a;
  const double square = u.squaredNorm();
  Similarity out;
  if (square > 0.0) {
    out.a = u.dot(v) / square;
    out.b = (u.x() * v.y() - u.y() * v.x()) / square;
  }
  out.shift = to_a - out.apply(from_a);
  return out;
}

HeadFrameFit fit_head_frame(const std::vector<Point2>& from,
                            const std::vector<Point2>& to,
                            double noise_px) {
  assert(from.size() == to.size());
  HeadFrameFit fit;
  if (from.size() < 4) return fit;
  fit.similarity = best_pair(from, to);
  std::vector<double> weight(from.size());
  std::vector<double> errors(from.size());
  double limit = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    for (size_t i = 0; i < from.size(); ++i) {
      errors[i] = squared_error(fit.similarity, from[i], to[i]);
    }
    limit = tukey_weights(errors, noise_px, weight);
    if (!least_squares(from, to, weight, fit.similarity)) return fit;
  }
  int inliers = 0;
  double sum = 0.0;
  for (size_t i = 0; i < from.size(); ++i) {
    const double error = squared_error(fit.similarity, from[i], to[i]);
    if (error < limit * limit) {
      ++inliers;
      sum += error;
    }
  }
  fit.inlier_share = static_cast<double>(inliers) / static_cast<double>(from.size());
  fit.rms_px = inliers > 0 ? std::sqrt(sum / inliers) : 0.0;
  const double scale = fit.similarity.scale();
  fit.ok = inliers >= 4 && std::isfinite(scale) && scale > 0.5 && scale < 2.0;
  return fit;
}

}  // namespace zygoma
