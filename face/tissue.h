// The force law of one tissue spring (paper, section 3, equation (1) and figure 1).
//
// Skin is biphasic: soft (alpha) while collagen uncoils, stiff (beta) beyond a critical elongation
// e_c. The print lets the force jump at e_c; a measured stress-strain curve is continuous, and with
// a jump no equilibrium exists between alpha e_c and beta e_c. Here the stiffness rises from alpha
// to beta by a cubic over [e_c - d, e_c + d], t = (e - e_c + d) / 2d:
//
//   k = alpha + (beta - alpha) (3 t^2 - 2 t^3),   f = alpha e + (beta - alpha) 2d (t^3 - t^4 / 2)
//
// so force is C2 in e and equals the continuous law outside of the band. In compression collagen
// fibres buckle and carry next to nothing, which leaves the resistance to the volume term: the
// stiffness falls from alpha to alpha_c by the same cubic over [-2 d_c, 0]. Without that a lattice
// of springs buckles itself, node against node, into one of many states. A spring's length is
// measured as sqrt(r.r + eps^2), which keeps a spring of length zero finite.
//
// The printed law (kLiteral: alpha e up to e_c, beta e beyond, the same in compression) is kept for
// study. Where the tension lies between alpha e_c and beta e_c no force balances it.
#pragma once

#include <cmath>

#include "face/geometry.h"

namespace zygoma {

enum class SpringLaw { kSmooth, kLiteral };

struct BiphasicLaw {
  double alpha = 0.0;          // stiffness at small elongation, mN/mm
  double stiffening = 0.0;     // beta - alpha; 0 = single phase
  double critical_mm = 0.0;    // e_c
  double band_mm = 0.0;        // d, half width of the transition, > 0 if stiffening > 0
  double slackening = 0.0;     // alpha - alpha_c, loss of stiffness in compression; 0 = none
  double slack_band_mm = 0.0;  // half width of that transition, > 0 if slackening > 0
  SpringLaw law = SpringLaw::kSmooth;
};

struct SpringResponse {
  double energy = 0.0;
  double force = 0.0;      // > 0 pulls the ends together
  double stiffness = 0.0;  // d force / d elongation
};

// A change of stiffness by 1 that sets in at `past` = 0, smoothed over [-d, d].
inline SpringResponse smooth_kink(double past, double d) {
  if (past <= -d) return {};
  if (past >= d) return {0.5 * past * past + 0.1 * d * d, past, 1.0};
  const double t = (past + d) / (2.0 * d);
  const double t3 = t * t * t;
  return {4.0 * d * d * t3 * t * (0.25 - 0.1 * t),
          2.0 * d * t3 * (1.0 - 0.5 * t),
          t * t * (3.0 - 2.0 * t)};
}

inline SpringResponse respond_literally(const BiphasicLaw& law, double e) {
  if (e <= law.critical_mm) return {0.5 * law.alpha * e * e, law.alpha * e, law.alpha};
  const double beta = law.alpha + law.stiffening;
  return {0.5 * beta * e * e - 0.5 * law.stiffening * law.critical_mm * law.critical_mm,
          beta * e,
          beta};
}

inline SpringResponse respond(const BiphasicLaw& law, double elongation_mm) {
  const double e = elongation_mm;
  if (law.law == SpringLaw::kLiteral) return respond_literally(law, e);
  SpringResponse r{0.5 * law.alpha * e * e, law.alpha * e, law.alpha};
  if (law.stiffening > 0.0 && e > law.critical_mm - law.band_mm) {
    const SpringResponse kink = smooth_kink(e - law.critical_mm, law.band_mm);
    r.energy += law.stiffening * kink.energy;
    r.force += law.stiffening * kink.force;
    r.stiffness += law.stiffening * kink.stiffness;
  }
  if (law.slackening > 0.0 && e < 0.0) {
    const SpringResponse kink = smooth_kink(-e - law.slack_band_mm, law.slack_band_mm);
    r.energy -= law.slackening * kink.energy;
    r.force += law.slackening * kink.force;
    r.stiffness -= law.slackening * kink.stiffness;
  }
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

// The same spring under the printed law.
Spring literal_spring(const Spring& spring);

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
