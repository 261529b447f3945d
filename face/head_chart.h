// The chart of the head: a flat domain (X, Y) in millimetres, wrapped around a bent spine inside
// the skull.
//
// The line of sight of a domain point starts on the spine and leaves at the angle a = |(X, E)| / R
// from straight ahead (azimuthal, so there is no pole at the crown); E(Y) is flat between chin and
// brow, where the ray is horizontal:
//
//   c(Y) = (0, Y - E(Y), z_c),   d = (sin a X/h, sin a E/h, cos a),   h = |(X, E)|
//
// so in front of the face x ~ X and y ~ Y, and the domain is read like a frontal picture. A shape
// is then one number per domain point, the distance r along the ray: bicubic B-spline over knots
// that are dense where a face is.
#pragma once

#include <vector>

#include "face/geometry.h"

namespace zygoma {

struct Ray {
  Vec3 origin_mm;
  Vec3 direction;
};

// Ray of a domain point, millimetres.
Ray chart_ray(const Vec2& domain_mm);

// r(X, Y), even in X: tensor product of cubic B-splines.
class DepthSpline {
 public:
  // Knots of X > 0 and 0 (mirrored inside) and of Y, both increasing; coefficients row-major, one
  // row per Y basis function from the lowest, one column per X basis function from the middle
  // outwards: (knots_y + 2) x (knots_x + 1).
  DepthSpline(std::vector<double> knots_x_mm,
              std::vector<double> knots_y_mm,
              std::vector<double> coefficients_mm);

  double operator()(const Vec2& domain_mm) const;

  // Basis function numbers (first of four) and values at a coordinate; X is taken by magnitude and
  // its basis is the full mirrored one.
  static int basis(const std::vector<double>& padded_knots, double t, double (&value)[4]);
  const std::vector<double>& padded_x() const { return padded_x_; }
  const std::vector<double>& padded_y() const { return padded_y_; }
  // Column of the coefficient table for a basis function of the mirrored knots.
  int column(int basis_function) const;
  int num_columns() const { return num_columns_; }

 private:
  std::vector<double> padded_x_;
  std::vector<double> padded_y_;
  std::vector<double> coefficients_mm_;
  int num_columns_ = 0;
};

}  // namespace zygoma
