// The force law of one tissue spring (paper, section 3, equation (1) and figure 1).
//
// Skin is biphasic: soft (alpha) while collagen uncoils, stiff (beta) beyond a critical elongation
// e_c. The print lets the force jump at e_c; a measured stress-strain curve is continuous, and with
// a jump no equilibrium exists between alpha e_c and beta e_c. Here the stiffness rises from alpha
// to beta by a cubic over [e_c - d, e_c + d], t = (e - e_c + d) / 2d:
//
//   k = alpha + (beta - alpha) (3 t^2 - 2 t^3),   f = alpha e + (beta - alpha) 2d (t^3 - t^4 / 2)
//
// so force is C2 in e and equals the continuous law outside of the band. A spring's length is
// measured as sqrt(r.r + eps^2), which keeps a spring of length zero finite.
#pragma once

#include <cmath>

#include "face/geometry.h"

namespace zygoma {

struct BiphasicLaw {
  double alpha = 0.0;        // stiffness at small elongation, mN/mm
  double stiffening = 0.0;   // beta - alpha; 0 = single phase
  double critical_mm = 0.0;  // e_c
  double band_mm = 0.0;      // d, half width of the transition, > 0 if stiffening > 0
};

struct SpringResponse {
  double energy = 0.0;
  double force = 0.0;      // > 0 pulls the ends together
  double stiffness = 0.0;  // d force / d elongation
};

inline SpringResponse respond(const BiphasicLaw& law, double elongation_mm) {
  const double e = elongation_mm;
  SpringResponse r{0.5 * law.alpha * e * e, law.alpha * e, law.alpha};
  const double past = e - law.critical_mm;
  const double d = law.band_mm;
  if (law.stiffening == 0.0 || past <= -d) return r;
  if (past >= d) {
    r.energy += law.stiffening * (0.5 * past * past + 0.1 * d * d);
    r.force += law.stiffening * past;
    r.stiffness += law.stiffening;
    return r;
  }
  const double t = (past + d) / (2.0 * d);
  const double t3 = t * t * t;
  r.energy += law.stiffening * 4.0 * d * d * t3 * t * (0.25 - 0.1 * t);
  r.force += law.stiffening * 2.0 * d * t3 * (1.0 - 0.5 * t);
  r.stiffness += law.stiffening * t * t * (3.0 - 2.0 * t);
  return r;
}

// Two nodes, the rest length between them and the law.
struct Spring {
  int i = 0;
  int j = 0;
  double softening_mm2 = 0.0;  // eps^2
  double rest_mm = 0.0;        // sqrt(L^2 + eps^2)
  BiphasicLaw law;
};

// A spring at rest between two nodes; `stiff_ratio` = beta / alpha >= 1, critical and band as
// shares of the rest length.
Spring make_spring(int i, int j, const Vec3& xi, const Vec3& xj, double alpha, double stiff_ratio);

// Energy of a spring; `gradient` is d(energy)/d(xj) = -d(energy)/d(xi).
inline double spring_energy(const Spring& spring, const Vec3& r, Vec3& gradient) {
  const double l = std::sqrt(r.squaredNorm() + spring.softening_mm2);
  const SpringResponse s = respond(spring.law, l - spring.rest_mm);
  gradient = (s.force / l) * r;
  return s.energy;
}

// Second derivative by the end-to-end vector: + on the diagonal blocks, - on the off-diagonal ones.
Eigen::Matrix3d spring_hessian(const Spring& spring, const Vec3& r);

}  // namespace zygoma
