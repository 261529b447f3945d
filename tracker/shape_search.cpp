#include "tracker/shape_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zygoma {

double shape_score(const ShapeFamily& family, const std::vector<double>& p) {
  double penalty = 0.0;
  for (size_t i = 0; i < p.size(); ++i) {
    const double z = (p[i] - family.usual[i]) / family.spread[i];
    penalty += z * z;
  }
  return family.evidence(p) - 0.5 * family.prior_weight * penalty;
}

std::vector<double> climb(const ShapeFamily& family,
                          std::vector<double> place,
                          double coarse,
                          double fine) {
  constexpr int kSweeps = 4;
  double value = shape_score(family, place);
  for (double step = coarse; step >= fine; step *= 0.5) {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool moved = false;
      for (size_t k = 0; k < place.size(); ++k) {
        for (const double sign : {-1.0, 1.0}) {
          const double before = place[k];
          place[k] += sign * step * family.reach[k];
          double s = value;
          if (std::abs(place[k] - family.usual[k]) <= family.reach[k]) {
            s = shape_score(family, place);
          }
          if (s > value) {
            value = s;
            moved = true;
            break;
          }
          place[k] = before;
        }
      }
      if (!moved) break;
    }
  }
  return place;
}

std::vector<double> search(const ShapeFamily& family) {
  constexpr int kGrid = 9;
  constexpr size_t kStarts = 5;
  std::vector<std::pair<double, std::vector<double>>> starts;
  std::vector<double> p = family.usual;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      p[0] = family.usual[0] + family.reach[0] * (2.0 * i / (kGrid - 1) - 1.0);
      if (p.size() > 1) p[1] = family.usual[1] + family.reach[1] * (2.0 * j / (kGrid - 1) - 1.0);
      starts.emplace_back(shape_score(family, p), p);
      if (p.size() < 2) break;
    }
  }
  std::stable_sort(
      starts.begin(), starts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  starts.resize(std::min(kStarts, starts.size()));
  std::vector<double> best = family.usual;
  double best_score = shape_score(family, best);
  for (const auto& [ignored, start] : starts) {
    const std::vector<double> top = climb(family, start, 0.25, 0.01);
    const double s = shape_score(family, top);
    if (s > best_score) {
      best_score = s;
      best = top;
    }
  }
  return best;
}

}  // namespace zygoma
