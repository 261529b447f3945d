#include "face/head_chart.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace zygoma {
namespace {

constexpr double kSpineZ = -85.0;
constexpr double kRadius = 95.0;

// 0 for t << 0, t for t >> 0, smooth over `width`.
double soft_ramp(double t, double width) {
  return t > 30.0 * width ? t : width * std::log1p(std::exp(t / width));
}

double elevation(double y) {
  constexpr double kBrow = 20.0;
  constexpr double kChin = -100.0;
  return soft_ramp(y - kBrow, 12.0) - 0.6 * soft_ramp(kChin - y, 10.0);
}

std::vector<double> pad(const std::vector<double>& knots) {
  std::vector<double> padded(3, knots.front());
  padded.insert(padded.end(), knots.begin(), knots.end());
  padded.insert(padded.end(), 3, knots.back());
  return padded;
}

}  // namespace

Ray chart_ray(const Vec2& domain_mm) {
  const double e = elevation(domain_mm.y());
  const double h = std::hypot(domain_mm.x(), e);
  const double a = h / kRadius;
  const double sin_over_h = h > 1e-9 ? std::sin(a) / h : 1.0 / kRadius;
  return {Vec3(0.0, domain_mm.y() - e, kSpineZ),
          Vec3(sin_over_h * domain_mm.x(), sin_over_h * e, std::cos(a))};
}

DepthSpline::DepthSpline(std::vector<double> knots_x_mm,
                         std::vector<double> knots_y_mm,
                         std::vector<double> coefficients_mm)
    : padded_y_(pad(knots_y_mm)), coefficients_mm_(std::move(coefficients_mm)) {
  std::vector<double> mirrored;
  for (std::size_t i = knots_x_mm.size() - 1; i > 0; --i) mirrored.push_back(-knots_x_mm[i]);
  mirrored.insert(mirrored.end(), knots_x_mm.begin(), knots_x_mm.end());
  padded_x_ = pad(mirrored);
  num_columns_ = static_cast<int>(knots_x_mm.size()) + 1;
  assert(coefficients_mm_.empty() ||
         coefficients_mm_.size() == (knots_y_mm.size() + 2) * num_columns_);
}

int DepthSpline::column(int basis_function) const {
  // 2 n - 1 + 2 functions over 2 n - 1 mirrored knots; the middle one is number n.
  return std::abs(basis_function - (num_columns_ - 1));
}

int DepthSpline::basis(const std::vector<double>& padded_knots, double t, double (&value)[4]) {
  const int last = static_cast<int>(padded_knots.size()) - 5;
  t = std::clamp(t, padded_knots.front(), padded_knots.back());
  const auto above = std::upper_bound(padded_knots.begin(), padded_knots.end(), t);
  const int span = std::clamp(static_cast<int>(above - padded_knots.begin()) - 1, 3, last);
  double left[4];
  double right[4];
  value[0] = 1.0;
  for (int j = 1; j <= 3; ++j) {  // Cox and de Boor
    left[j] = t - padded_knots[span + 1 - j];
    right[j] = padded_knots[span + j] - t;
    double saved = 0.0;
    for (int k = 0; k < j; ++k) {
      const double part = value[k] / (right[k + 1] + left[j - k]);
      value[k] = saved + right[k + 1] * part;
      saved = left[j - k] * part;
    }
    value[j] = saved;
  }
  return span - 3;
}

double DepthSpline::operator()(const Vec2& domain_mm) const {
  double bx[4];
  double by[4];
  const int first_x = basis(padded_x_, std::abs(domain_mm.x()), bx);
  const int first_y = basis(padded_y_, domain_mm.y(), by);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double* row = coefficients_mm_.data() + (first_y + i) * num_columns_;
    for (int k = 0; k < 4; ++k) sum += by[i] * bx[k] * row[column(first_x + k)];
  }
  return sum;
}

}  // namespace zygoma
