#include "tracker/lid_model.h"

#include "tracker/robust.h"
#include "tracker/shape_search.h"

namespace zygoma {
namespace {

constexpr double kDepth = 0.06;  // of the lids before the plane of the eyes, eye distances

double lid_evidence(const Evidence& evidence, const Lid& lid, const HeadTurn& turn) {
  const bool left = lid.outer.x() > lid.inner.x();
  return evidence_under(evidence, left ? kEyelidLeft : kEyelidRight, lid_nodes(lid, turn));
}

}  // namespace

std::vector<Point2> lid_nodes(const Lid& lid, const HeadTurn& turn) {
  const int count = kFeatureSchema[kEyelidLeft].num_nodes;
  std::vector<Point2> nodes;
  nodes.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / (count - 1);
    const Point2 up(0.0, -4.0 * t * (1.0 - t) * lid.rise * kChartEyeDistance);
    nodes.push_back(
        turn.apply(lid.inner + t * (lid.outer - lid.inner) + up, kDepth * kChartEyeDistance));
  }
  return nodes;
}

Lid usual_lid(bool left) {
  const double side = left ? 1.0 : -1.0;
  return {chart_point(0.27 * side, 0.05), chart_point(0.7 * side, 0.015), 0.1, 0.1};
}

Lid find_lid(const Evidence& evidence, bool left) {
  const Lid usual = usual_lid(left);
  const auto placed = [&](const std::vector<double>& p) {
    const Point2 shift = kChartEyeDistance * Point2(0.0, p[1]);
    const Point2 tilt = kChartEyeDistance * Point2(0.0, p[2]);
    return Lid{usual.inner + shift - tilt, usual.outer + shift + tilt, p[0], p[0]};
  };
  ShapeFamily family;
  family.usual = {usual.rise, 0.0, 0.0};
  family.spread = {0.025, 0.025, 0.02};
  family.reach = {0.07, 0.06, 0.04};
  family.prior_weight = 0.1;
  family.evidence = [&](const std::vector<double>& p) {
    return lid_evidence(evidence, placed(p), {});
  };
  return placed(search(family));
}

Lid follow_lid(const Evidence& evidence, const Lid& last, const HeadTurn& turn) {
  constexpr double kShut = -0.05;     // eye distances
  constexpr double kStartled = 0.07;  // above the open lid
  constexpr int kSteps = 20;
  constexpr double kStay = 0.06;  // spread of a frame's change; a blink may go further
  constexpr double kPrior = 0.05;
  const double from = kShut;
  const double step = (last.open_rise + kStartled - kShut) / kSteps;
  Lid lid = last;
  const auto score = [&](double rise) {
    lid.rise = rise;
    const double stay = (rise - last.rise) / kStay;
    const double home = (rise - last.open_rise) / (2.0 * kStay);
    return lid_evidence(evidence, lid, turn) - 0.5 * kPrior * (stay * stay + home * home);
  };
  std::vector<double> scores;
  for (int i = 0; i <= kSteps; ++i) scores.push_back(score(from + i * step));
  size_t best = 0;
  for (size_t i = 1; i < scores.size(); ++i) {
    if (scores[i] > scores[best]) best = i;
  }
  double offset = 0.0;
  if (best > 0 && best + 1 < scores.size()) {
    offset = parabola_summit(scores[best - 1], scores[best], scores[best + 1]);
  }
  lid.rise = from + (static_cast<double>(best) + offset) * step;
  return lid;
}

}  // namespace zygoma
