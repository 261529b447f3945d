#include "tracker/mouth_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zygoma {
namespace {

constexpr double kThreshold = 0.45;  // of the lip map (of one) between skin and mouth
constexpr double kUsualArea = 0.14;  // of a mouth, square eye distances
constexpr double kRegionWeight = 1.5;
constexpr int kColumns = 24;
constexpr double kLineWidth_px = 4.0;  // of the seam as the smoothed picture has it
// How far a mouth goes from its rest, and how much that counts: enough to come home by.
constexpr std::array<double, Mouth::kNumParameters> kMotion{0.1, 0.14, 0.05, 0.05, 0.1, 0.05, 0.06};
constexpr double kRestWeight = 0.03;

struct Knot {
  double s;
  double height;
};
constexpr std::array<Knot, 5> kUpperProfile{
    {{0, 0.86}, {0.26, 1.0}, {0.55, 0.78}, {0.8, 0.42}, {1, 0}}};
constexpr std::array<Knot, 5> kLowerProfile{
    {{0, 1.0}, {0.28, 0.96}, {0.6, 0.72}, {0.8, 0.44}, {1, 0}}};

// The lip's height at s, of the parameter for it: piecewise linear.
double profile(bool upper, double s) {
  const std::array<Knot, 5>& knots = upper ? kUpperProfile : kLowerProfile;
  const double q = std::min(1.0, std::abs(s));
  size_t k = 1;
  while (k + 1 < knots.size() && q > knots[k].s) ++k;
  const double u = (q - knots[k - 1].s) / (knots[k].s - knots[k - 1].s);
  return knots[k - 1].height + u * (knots[k].height - knots[k - 1].height);
}

// Places along the outline, s in [-1, 1] from the subject's right corner to the left.
struct Station {
  double s;
  double upper;
  double lower;
};

std::vector<Station> stations(int count, bool at_ends) {
  std::vector<Station> list;
  for (int i = 0; i < count; ++i) {
    const double s = at_ends ? 2.0 * i / (count - 1) - 1.0 : (2.0 * i + 1.0) / count - 1.0;
    list.push_back({s, profile(true, s), profile(false, s)});
  }
  return list;
}

Point2 outline(const std::vector<double>& p, bool upper, const Station& at) {
  const double rise = upper ? -p[Mouth::kUpper] * at.upper : p[Mouth::kLower] * at.lower;
  return chart_point(
      p[Mouth::kMiddle] + p[Mouth::kHalfWidth] * at.s,
      p[Mouth::kHeight] + rise + p[Mouth::kTilt] * at.s + p[Mouth::kBend] * (1.0 - at.s * at.s));
}

double region_gain(const Evidence& evidence, const std::vector<double>& p) {
  static const std::vector<Station> columns = stations(kColumns, false);
  double sum = 0.0;
  for (const Station& column : columns) {
    const Point2 top = outline(p, true, column);
    const Point2 bottom = outline(p, false, column);
    sum += evidence.lip_column(top.x(), top.y(), bottom.y()) -
           kThreshold * std::max(0.0, bottom.y() - top.y());
  }
  const double column_width = 2.0 * p[Mouth::kHalfWidth] * kChartEyeDistance / kColumns;
  return sum * column_width / (kUsualArea * kChartEyeDistance * kChartEyeDistance);
}

// How much of the middle of an upper border lies on the upper edge of a dark line, not of a lip:
// brightness rises again a line's width below it. Towards the corners it does so on any mouth.
double line_under(const Evidence& evidence, const std::vector<double>& p) {
  static const std::vector<Station> places = [] {
    std::vector<Station> middle = stations(9, false);
    std::erase_if(middle, [](const Station& at) { return std::abs(at.s) > 0.5; });
    return middle;
  }();
  double sum = 0.0;
  for (const Station& at : places) {
    const Point2 q = outline(p, true, at);
    const double fall = -evidence.fine.image_gradient(q).y();
    const double rise = evidence.fine.image_gradient(q + Point2(0.0, kLineWidth_px)).y();
    sum += std::max(0.0, std::min(fall, rise));
  }
  return sum / static_cast<double>(places.size());
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
  static const std::vector<Station> upper_nodes =
      stations(kFeatureSchema[kUpperLip].num_nodes, true);
  static const std::vector<Station> lower_nodes =
      stations(kFeatureSchema[kLowerLip].num_nodes, true);
  const std::vector<Station>& places = upper ? upper_nodes : lower_nodes;
  std::vector<Point2> nodes;
  nodes.reserve(places.size());
  for (const Station& at : places) nodes.push_back(outline(mouth.p, upper, at));
  return nodes;
}

Mouth find_mouth(const Evidence& evidence, const Mouth& usual, bool use_region, double line_cost) {
  ShapeFamily family;
  family.usual = usual.p;
  family.spread = {0.08, 0.06, 0.03, 0.05, 0.045, 0.03, 0.02};
  family.reach = {0.26, 0.14, 0.09, 0.09, 0.14, 0.05, 0.08};
  family.prior_weight = 0.08;
  family.evidence = [&](const std::vector<double>& p) {
    return mouth_evidence(evidence, p, use_region) - line_cost * line_under(evidence, p);
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
  constexpr double kCoarse = 0.12;  // of the reach
  Mouth open = rest;
  open.p[Mouth::kLower] += 0.2;
  Mouth smile = rest;
  smile.p[Mouth::kHeight] -= 0.1;
  smile.p[Mouth::kHalfWidth] += 0.1;
  smile.p[Mouth::kBend] += 0.06;
  // Two starts climb as far as coarse steps go: where the mouth was, and the best of the others.
  // The better of the two climbs all the way.
  const std::vector<double>* other = &rest.p;
  double other_fit = shape_score(family, rest.p);
  for (const Mouth* mouth : {&open, &smile}) {
    const double fit = shape_score(family, mouth->p);
    if (fit > other_fit) {
      other_fit = fit;
      other = &mouth->p;
    }
  }
  std::vector<double> best = climb(family, last.p, kCoarse, 0.4 * kCoarse);
  std::vector<double> rival = climb(family, *other, kCoarse, 0.4 * kCoarse);
  if (shape_score(family, rival) > shape_score(family, best)) best = std::move(rival);
  return {climb(family, best, 0.25 * kCoarse, 0.005)};
}

}  // namespace zygoma
