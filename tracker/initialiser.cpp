#include "tracker/initialiser.h"

#include <algorithm>
#include <cmath>

#include "tracker/mouth_start.h"

namespace zygoma {
namespace {

constexpr double kLowerEdge = 0.6;  // of a brow, against the upper

// Brow: p = {height of the middle, tilt, arch, thickness}. side = +1 left, -1 right.
std::vector<Point2> brow(double side, const std::vector<double>& p) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) {
    const double t = i / 8.0;
    const double from_middle = 2.0 * t - 1.0;
    const double y = p[0] + p[1] * from_middle + p[2] * (from_middle * from_middle - 0.35);
    nodes.push_back(chart_point(side * (0.25 + 0.66 * t), y));
  }
  return nodes;
}

// Base of the nose: p = {height of its lowest point, middle x}.
std::vector<Point2> nose(const std::vector<double>& p) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) {
    const double s = i / 4.0 - 1.0;
    nodes.push_back(chart_point(p[1] + 0.2 * s, p[0] - 0.08 * s * s));
  }
  return nodes;
}

std::vector<Point2> chin(const std::vector<double>& p) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) {
    const double s = i / 4.0 - 1.0;
    nodes.push_back(chart_point(p[1] + 0.26 * s, p[0] - 0.06 * s * s));
  }
  return nodes;
}

std::vector<Point2> hairline(const std::vector<double>& p) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 13; ++i) {
    const double s = i / 6.0 - 1.0;
    nodes.push_back(chart_point(0.6 * s, p[0] + p[1] * s * s));
  }
  return nodes;
}

// From beside the wing of the nose to beside the corner of the mouth.
std::vector<Point2> furrow(const Point2& wing, const Point2& corner, double side) {
  const Point2 out{side * kChartEyeDistance, 0.0};
  const Point2 top = wing + 0.07 * out - Point2(0.0, 0.12 * kChartEyeDistance);
  const Point2 bottom = corner + 0.12 * out;
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) {
    const double t = i / 8.0;
    nodes.push_back((1.0 - t) * top + t * bottom + std::sin(t * 3.14159265358979) * 0.025 * out);
  }
  return nodes;
}

}  // namespace

std::vector<Point2> furrow_between(const std::vector<Point2>& nose_tip,
                                   const std::vector<Point2>& upper_lip,
                                   bool left) {
  return left ? furrow(nose_tip.back(), upper_lip.back(), 1.0)
              : furrow(nose_tip.front(), upper_lip.front(), -1.0);
}

namespace {

std::vector<Point2> settle(std::vector<Point2> nodes,
                           const Evidence& evidence,
                           FeatureIndex feature,
                           double hold) {
  const ContourLandscape landscape(evidence, feature, nodes);
  Snake snake(nodes, snake_options(feature));
  std::vector<SoftAnchor> anchors(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) anchors[i] = {nodes[i], hold};
  snake.set_anchors(anchors);
  snake.relax(&landscape);
  return resample(snake.nodes(), static_cast<int>(nodes.size()));
}

// How much a contour stays where the search saw it: furrows hardly show, and next to a pale border
// of the lips is the dark line between them.
double hold_of(FeatureIndex feature) {
  switch (feature) {
    case kFurrowLeft:
    case kFurrowRight:
      return 0.2;
    case kUpperLip:
    case kLowerLip:
      return 0.1;
    default:
      return 0.02;
  }
}

void place_brow(const Evidence& evidence, FeatureIndex feature, ContourNodes& out) {
  const double side = feature == kBrowLeft ? 1.0 : -1.0;
  ShapeFamily model;
  model.usual = {-0.42, 0.0, 0.06, 0.1};
  model.spread = {0.07, 0.06, 0.04, 0.025};
  model.reach = {0.22, 0.12, 0.08, 0.05};
  model.prior_weight = 0.1;
  // The lashes of an open eye have such an upper edge too, but under them is the eye, not skin.
  model.evidence = [&evidence, feature, side](const std::vector<double>& p) {
    const std::vector<Point2> upper = brow(side, p);
    std::vector<Point2> lower = upper;
    for (Point2& node : lower) node.y() += p[3] * kChartEyeDistance;
    return evidence_under(evidence, feature, upper) +
           kLowerEdge * evidence_under(evidence, kNoseTip, lower);
  };
  out[feature] = brow(side, search(model));
}

}  // namespace

SnakeOptions snake_options(FeatureIndex feature) {
  SnakeOptions options;
  switch (feature) {
    case kBrowLeft:
    case kBrowRight:
      options.rigidity = 0.06;
      break;
    case kUpperLip:
    case kLowerLip:
      options.rigidity = 0.02;
      break;
    case kNoseTip:
    case kEyelidLeft:
    case kEyelidRight:
      options.rigidity = 0.08;
      break;
    case kFurrowLeft:
    case kFurrowRight:
      options.rigidity = 0.3;
      break;
    default:
      options.rigidity = 0.2;
      break;
  }
  return options;
}

ContourNodes template_contours() {
  ContourNodes out;
  out[kBrowLeft] = brow(1.0, {-0.42, 0.0, 0.06});
  out[kBrowRight] = brow(-1.0, {-0.42, 0.0, 0.06});
  out[kUpperLip] = lip_nodes(Mouth(), true);
  out[kLowerLip] = lip_nodes(Mouth(), false);
  out[kNoseTip] = nose({0.75, 0.0});
  out[kChinBoss] = chin({1.86, 0.0});
  out[kHairline] = hairline({-1.2, 0.25});
  out[kEyelidLeft] = lid_nodes(usual_lid(true));
  out[kEyelidRight] = lid_nodes(usual_lid(false));
  out[kFurrowLeft] = furrow_between(out[kNoseTip], out[kUpperLip], true);
  out[kFurrowRight] = furrow_between(out[kNoseTip], out[kUpperLip], false);
  return out;
}

void join_lip_ends(ContourNodes& contours) {
  const auto join = [](Point2& a, Point2& b) { a = b = 0.5 * (a + b); };
  join(contours[kUpperLip].front(), contours[kLowerLip].front());
  join(contours[kUpperLip].back(), contours[kLowerLip].back());
}

PlacedFace place_contours(const FaceChart& chart) {
  PlacedFace face;
  ContourNodes& out = face.contours;
  LipMap& lips = face.lips;
  Mouth& mouth = face.mouth;
  out = template_contours();
  const MouthStart start = start_mouth(chart);
  mouth = start.mouth;
  face.rest = start.rest;
  lips = start.lips;
  out[kUpperLip] = lip_nodes(mouth, true);
  out[kLowerLip] = lip_nodes(mouth, false);
  EvidenceOptions places;
  places.mouth_line_px = out[kUpperLip].front().y();
  const Evidence evidence = make_evidence(chart, lips, places);
  place_brow(evidence, kBrowLeft, out);
  place_brow(evidence, kBrowRight, out);
  face.left_lid = find_lid(evidence, true);
  face.right_lid = find_lid(evidence, false);
  out[kEyelidLeft] = lid_nodes(face.left_lid);
  out[kEyelidRight] = lid_nodes(face.right_lid);
  const double mouth_y =
      (0.5 * (out[kUpperLip].front().y() + out[kUpperLip].back().y()) - kChartEyeMiddle.y()) /
      kChartEyeDistance;

  ShapeFamily model;
  model.usual = {mouth_y - 0.41, 0.0};
  model.spread = {0.06, 0.04};
  model.reach = {0.14, 0.08};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kNoseTip, nose(p));
  };
  out[kNoseTip] = nose(search(model));
  // An open jaw carries the chin down with the lower lip.
  const double opening = mouth.p[Mouth::kLower] - start.rest.p[Mouth::kLower];
  model.usual = {mouth_y + 0.71 + 0.7 * opening, 0.0};
  model.spread = {0.05, 0.05};
  model.reach = {0.16, 0.06};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kChinBoss, chin(p));
  };
  out[kChinBoss] = chin(search(model));
  model.usual = {-1.2, 0.25};
  model.spread = {0.15, 0.1};
  model.reach = {0.35, 0.2};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kHairline, hairline(p));
  };
  out[kHairline] = hairline(search(model));
  out[kFurrowLeft] = furrow_between(out[kNoseTip], out[kUpperLip], true);
  out[kFurrowRight] = furrow_between(out[kNoseTip], out[kUpperLip], false);

  // Coarse to fine: blur much, settle, blur less.
  for (const double blur : {1.6, 1.0}) {
    EvidenceOptions options;
    options.fine_sigma_px *= blur;
    options.coarse_sigma_px *= blur;
    options.lips_sigma_px *= blur;
    const Evidence level = make_evidence(chart, lips, options);
    for (size_t f = 0; f < kNumFeatures; ++f) {
      const auto feature = static_cast<FeatureIndex>(f);
      out[f] = settle(out[f], level, feature, hold_of(feature));
    }
    join_lip_ends(out);
  }
  return face;
}

}  // namespace zygoma
