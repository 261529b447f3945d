#include "face/tissue.h"

#include <algorithm>

namespace zygoma {
namespace {

constexpr double kSofteningShare = 1e-3;  // eps / L
constexpr double kCriticalShare = 0.15;   // e_c / L
constexpr double kBandShare = 0.02;       // d / L
constexpr double kSlackRatio = 0.1;       // alpha_c / alpha
constexpr double kSlackBandShare = 0.03;  // d_c / L
constexpr double kSofteningMm = 0.3;      // eps is at least this: a shorter spring turns around at
                                          // the least push, which no step of a solver can follow

}  // namespace

Spring make_spring(int i, int j, const Vec3& xi, const Vec3& xj, double alpha, double stiff_ratio) {
  const Vec3 r = xj - xi;
  const double length = r.norm();
  const double softening = std::max(kSofteningShare * length, kSofteningMm);
  Spring spring{i, j, softening * softening, 0.0, {}};
  // The very expression of spring_energy, so that the force at rest is exactly zero.
  spring.rest_mm = std::sqrt(r.squaredNorm() + spring.softening_mm2);
  spring.law = {alpha,
                alpha * (stiff_ratio - 1.0),
                kCriticalShare * spring.rest_mm,
                kBandShare * spring.rest_mm,
                alpha * (1.0 - kSlackRatio),
                kSlackBandShare * spring.rest_mm};
  return spring;
}

Spring literal_spring(const Spring& spring) {
  Spring literal = spring;
  literal.law.law = SpringLaw::kLiteral;
  literal.law.slackening = 0.0;
  return literal;
}

Eigen::Matrix3d spring_hessian(const Spring& spring, const Vec3& r) {
  const double l2 = r.squaredNorm() + spring.softening_mm2;
  const double l = std::sqrt(l2);
  const SpringResponse s = respond(spring.law, l - spring.rest_mm);
  const double across = s.force / l;
  Eigen::Matrix3d hessian = ((s.stiffness - across) / l2) * r * r.transpose();
  hessian.diagonal().array() += across;
  return hessian;
}

}  // namespace zygoma
