#include "tracker/mouth_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace zygoma {
namespace {

constexpr double kThreshold = 0.45;  // of the lip map (of one) between skin and mouth
constexpr double kUsualArea = 0.14;  // of a mouth, square eye distances
constexpr double kRegionWeight = 1.5;
constexpr int kColumns = 24;
// How far a mouth goes from its rest, and how much that counts: enough to come home by.
constexpr std::array<double, Mouth::kNumParameters> kMotion{0.1, 0.14, 0.05, 0.05, 0.1, 0.05, 0.06};
constexpr double kRestWeight = 0.03;

// Piecewise linear through (s, value) pairs.
double through(std::initializer_list<Point2> knots, double s) {
  const Point2* before = knots.begin();
  for (const Point2* k = knots.begin() + 1; k != knots.end(); ++k) {
    if (s <= k->x() || k + 1 == knots.end()) {
      const double u = std::clamp((s - before->x()) / (k->x() - before->x()), 0.0, 1.0);
      return before->y() + u * (k->y() - before->y());
    }
    before = k;
  }
  return before->y();
}

// Chart point of the outline at s in [-1, 1] from the subject's right corner to the left.
Point2 outline(const std::vector<double>& p, bool upper, double s) {
  const double q = std::abs(s);
  const double rise =
      upper ? -p[Mouth::kUpper] *
                  through({{0, 0.86}, {0.26, 1.0}, {0.55, 0.78}, {0.8, 0.42}, {1, 0}}, q)
            : p[Mouth::kLower] *
                  through({{0, 1.0}, {0.28, 0.96}, {0.6, 0.72}, {0.8, 0.44}, {1, 0}}, q);
  return chart_point(
      p[Mouth::kMiddle] + p[Mouth::kHalfWidth] * s,
      p[Mouth::kHeight] + rise + p[Mouth::kTilt] * s + p[Mouth::kBend] * (1.0 - s * s));
}

double region_gain(const Evidence& evidence, const std::vector<double>& p) {
  double sum = 0.0;
  for (int i = 0; i < kColumns; ++i) {
    const double s = (2.0 * i + 1.0) / kColumns - 1.0;
    const Point2 top = outline(p, true, s);
    const Point2 bottom = outline(p, false, s);
    sum += evidence.lip_column(top.x(), top.y(), bottom.y()) -
           kThreshold * std::max(0.0, bottom.y() - top.y());
  }
  const double column_width = 2.0 * p[Mouth::kHalfWidth] * kChartEyeDistance / kColumns;
  return sum * column_width / (kUsualArea * kChartEyeDistance * kChartEyeDistance);
}

double mouth_evidence(const Evidence& evidence, const std::vector<double>& p, bool use_region) {
  // An outline turned inside out is no mouth, nor is one that takes in the chin.
  if (p[Mouth::kUpper] < 0.01 || p[Mouth::kLower] < 0.02 || p[Mouth::kLower] > 0.62) return -10.0;
  const Mouth mouth{p};
  const double edges = evidence_under(evidence, kUpperLip, lip_nodes(mouth, true)) +
                       evidence_under(evidence, kLowerLip, lip_nodes(mouth, false));
  return use_region ? 0.5 * edges + kRegionWeight * region_gain(evidence, p) : edges;
}

}  // namespace

std::vector<Point2> lip_nodes(const Mouth& mouth, bool upper) {
  const int n = kFeatureSchema[upper ? kUpperLip : kLowerLip].num_nodes;
  std::vector<Point2> nodes;
  for (int i = 0; i < n; ++i) nodes.push_back(outline(mouth.p, upper, 2.0 * i / (n - 1) - 1.0));
  return nodes;
}

Mouth find_mouth(const Evidence& evidence, bool use_region) {
  ShapeFamily family;
  family.usual = Mouth().p;
  family.spread = {0.08, 0.06, 0.03, 0.05, 0.045, 0.03, 0.02};
  family.reach = {0.26, 0.14, 0.09, 0.09, 0.14, 0.05, 0.08};
  family.prior_weight = 0.08;
  family.evidence = [&](const std::vector<double>& p) {
    return mouth_evidence(evidence, p, use_region);
  };
  return {search(family)};
}

Mouth follow_mouth(const Evidence& evidence, const Mouth& last, const Mouth& rest) {
  ShapeFamily family;
  family.usual = last.p;
  family.spread = {0.05, 0.08, 0.04, 0.03, 0.05, 0.03, 0.03};
  family.reach = {0.25, 0.35, 0.2, 0.1, 0.2, 0.08, 0.15};
  family.prior_weight = 0.02;
  family.evidence = [&](const std::vector<double>& p) {
    double far = 0.0;
    for (size_t i = 0; i < p.size(); ++i) {
      const double z = (p[i] - rest.p[i]) / kMotion[i];
      far += z * z;
    }
    return mouth_evidence(evidence, p, true) - 0.5 * kRestWeight * far;
  };
  Mouth open = rest;
  open.p[Mouth::kLower] += 0.2;
  Mouth smile = rest;
  smile.p[Mouth::kHeight] -= 0.1;
  smile.p[Mouth::kHalfWidth] += 0.1;
  smile.p[Mouth::kBend] += 0.06;
  Mouth best = last;
  double best_score = -1e300;
  for (const Mouth* start :
       {&last, &rest, static_cast<const Mouth*>(&open), static_cast<const Mouth*>(&smile)}) {
    const std::vector<double> p =
        climb(family, start->p, start == &last ? 0.16 : 0.12, start == &last ? 0.005 : 0.02);
    const double value = shape_score(family, p);
    if (value > best_score) {
      best_score = value;
      best.p = p;
    }
  }
  return best;
}

}  // namespace zygoma
