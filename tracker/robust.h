// What fits that must not follow outliers share.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace zygoma {

// The upper median of values that are there; their order is lost.
inline double median(std::vector<double>& values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Tukey's weights of 2-D errors, zero from four robust spreads on: that distance is returned. The
// spread is at least `noise_px`.
inline double tukey_weights(const std::vector<double>& squared_errors,
                            double noise_px,
                            std::vector<double>& weight) {
  constexpr double kSpreads = 4.0;
  constexpr double kSpreadOfMedian = 0.85;  // the median error of a Gaussian of spread one is 1.18
  std::vector<double> sorted = squared_errors;
  const double limit = kSpreads * std::max(noise_px, kSpreadOfMedian * std::sqrt(median(sorted)));
  for (size_t i = 0; i < weight.size(); ++i) {
    const double q = 1.0 - squared_errors[i] / (limit * limit);
    weight[i] = q > 0.0 ? q * q : 0.0;
  }
  return limit;
}

// Where a parabola through three values at -1, 0 and 1 has its summit, [-0.5, 0.5]; 0 if it has
// none.
inline double parabola_summit(double before, double at, double after) {
  const double bend = before - 2.0 * at + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace zygoma
