#include "tracker/initialiser.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace zygoma {
namespace {

// A curve family: parameters (eye distances) -> nodes, with usual values and spreads.
struct Model {
  std::vector<double> usual;
  std::vector<double> spread;
  std::vector<double> reach;  // half width of the search, in eye distances
  std::function<double(const std::vector<double>&)> evidence;
  double prior_weight = 0.15;
};

double score(const Model& model, const std::vector<double>& p) {
  double penalty = 0.0;
  for (size_t i = 0; i < p.size(); ++i) {
    const double z = (p[i] - model.usual[i]) / model.spread[i];
    penalty += z * z;
  }
  return model.evidence(p) - 0.5 * model.prior_weight * penalty;
}

// A full grid in the first two parameters, from every point of it a descent in all of them would be
// too dear; instead the best few grid points are refined by a pattern search.
std::vector<double> maximise(const Model& model) {
  constexpr int kGrid = 9;
  constexpr size_t kStarts = 5;
  std::vector<std::pair<double, std::vector<double>>> starts;
  const size_t n = model.usual.size();
  std::vector<double> p = model.usual;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      p[0] = model.usual[0] + model.reach[0] * (2.0 * i / (kGrid - 1) - 1.0);
      if (n > 1) p[1] = model.usual[1] + model.reach[1] * (2.0 * j / (kGrid - 1) - 1.0);
      starts.emplace_back(score(model, p), p);
      if (n < 2) break;
    }
  }
  std::stable_sort(
      starts.begin(), starts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  starts.resize(std::min(kStarts, starts.size()));
  for (auto& [value, place] : starts) {
    for (double step = 0.25; step > 0.01; step *= 0.5) {
      for (int sweep = 0; sweep < 4; ++sweep) {
        bool moved = false;
        for (size_t k = 0; k < n; ++k) {
          for (const double sign : {-1.0, 1.0}) {
            std::vector<double> trial = place;
            trial[k] += sign * step * model.reach[k];
            if (std::abs(trial[k] - model.usual[k]) > model.reach[k]) continue;
            const double s = score(model, trial);
            if (s > value) {
              value = s;
              place = trial;
              moved = true;
            }
          }
        }
        if (!moved) break;
      }
    }
  }
  return std::max_element(starts.begin(),
                          starts.end(),
                          [](const auto& a, const auto& b) { return a.first < b.first; })
      ->second;
}

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

// Brow: p = {height of the middle, tilt, arch}. side = +1 left, -1 right.
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

// Mouth: p = {corner height, middle x, half width, height of the upper lip, of the lower, tilt}.
std::vector<Point2> lip(bool upper, const std::vector<double>& p) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 13; ++i) {
    const double s = i / 6.0 - 1.0;
    const double q = std::abs(s);
    const double rise = upper ? -p[3] * through({{0, 0.84}, {0.26, 1.0}, {0.55, 0.74}, {1, 0}}, q)
                              : p[4] * through({{0, 1.0}, {0.28, 0.96}, {0.6, 0.7}, {1, 0}}, q);
    nodes.push_back(chart_point(p[1] + p[2] * s, p[0] + rise + p[5] * s));
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
  const Point2 top = wing + 0.07 * out;
  const Point2 bottom = corner + 0.12 * out;
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) {
    const double t = i / 8.0;
    nodes.push_back((1.0 - t) * top + t * bottom + std::sin(t * 3.14159265358979) * 0.025 * out);
  }
  return nodes;
}

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

void place_mouth(const Evidence& evidence, ContourNodes& out) {
  Model mouth;
  mouth.usual = {1.15, 0.0, 0.375, 0.13, 0.16, 0.0};
  mouth.spread = {0.08, 0.05, 0.045, 0.035, 0.06, 0.03};
  mouth.reach = {0.26, 0.09, 0.12, 0.08, 0.14, 0.05};
  mouth.prior_weight = 0.05;
  mouth.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kUpperLip, lip(true, p)) +
           evidence_under(evidence, kLowerLip, lip(false, p));
  };
  const std::vector<double> p = maximise(mouth);
  out[kUpperLip] = lip(true, p);
  out[kLowerLip] = lip(false, p);
}

void place_brow(const Evidence& evidence, FeatureIndex feature, ContourNodes& out) {
  const double side = feature == kBrowLeft ? 1.0 : -1.0;
  Model model;
  model.usual = {-0.42, 0.0, 0.06};
  model.spread = {0.07, 0.06, 0.04};
  model.reach = {0.2, 0.12, 0.08};
  model.prior_weight = 0.1;
  model.evidence = [&evidence, feature, side](const std::vector<double>& p) {
    return evidence_under(evidence, feature, brow(side, p));
  };
  out[feature] = brow(side, maximise(model));
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
  const std::vector<double> mouth{1.15, 0.0, 0.375, 0.13, 0.16, 0.0};
  out[kUpperLip] = lip(true, mouth);
  out[kLowerLip] = lip(false, mouth);
  out[kNoseTip] = nose({0.75, 0.0});
  out[kChinBoss] = chin({1.86, 0.0});
  out[kHairline] = hairline({-1.2, 0.25});
  out[kFurrowLeft] = furrow(out[kNoseTip].back(), out[kUpperLip].back(), 1.0);
  out[kFurrowRight] = furrow(out[kNoseTip].front(), out[kUpperLip].front(), -1.0);
  return out;
}

ContourNodes place_contours(const FaceChart& chart, const Evidence& evidence) {
  ContourNodes out = template_contours();
  place_mouth(evidence, out);
  place_brow(evidence, kBrowLeft, out);
  place_brow(evidence, kBrowRight, out);
  const double mouth_y =
      (0.5 * (out[kUpperLip].front().y() + out[kUpperLip].back().y()) - kChartEyeMiddle.y()) /
      kChartEyeDistance;

  Model model;
  model.usual = {mouth_y - 0.41, 0.0};
  model.spread = {0.06, 0.04};
  model.reach = {0.14, 0.08};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kNoseTip, nose(p));
  };
  out[kNoseTip] = nose(maximise(model));
  model.usual = {mouth_y + 0.71, 0.0};
  model.spread = {0.05, 0.05};
  model.reach = {0.16, 0.06};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kChinBoss, chin(p));
  };
  out[kChinBoss] = chin(maximise(model));
  model.usual = {-1.2, 0.25};
  model.spread = {0.15, 0.1};
  model.reach = {0.35, 0.2};
  model.evidence = [&evidence](const std::vector<double>& p) {
    return evidence_under(evidence, kHairline, hairline(p));
  };
  out[kHairline] = hairline(maximise(model));
  out[kFurrowLeft] = furrow(out[kNoseTip].back(), out[kUpperLip].back(), 1.0);
  out[kFurrowRight] = furrow(out[kNoseTip].front(), out[kUpperLip].front(), -1.0);

  // Coarse to fine: blur much, settle, blur less.
  for (const double blur : {1.6, 1.0}) {
    EvidenceOptions options;
    options.fine_sigma_px *= blur;
    options.coarse_sigma_px *= blur;
    options.lips_sigma_px *= blur;
    const Evidence level = make_evidence(chart, options);
    for (size_t f = 0; f < kNumFeatures; ++f) {
      const bool weak = f == kFurrowLeft || f == kFurrowRight;
      out[f] = settle(out[f], level, static_cast<FeatureIndex>(f), weak ? 0.2 : 0.02);
    }
    const auto join = [](Point2& a, Point2& b) { a = b = 0.5 * (a + b); };
    join(out[kUpperLip].front(), out[kLowerLip].front());
    join(out[kUpperLip].back(), out[kLowerLip].back());
  }
  return out;
}

}  // namespace zygoma
