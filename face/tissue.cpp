#include "face/tissue.h"

namespace zygoma {
namespace {

constexpr double kSofteningShare = 1e-3;  // eps / L
constexpr double kCriticalShare = 0.15;   // e_c / L
constexpr double kBandShare = 0.02;       // d / L
constexpr double kShortestMm = 1e-6;  // a spring between coincident nodes keeps a finite Hessian

}  // namespace

Spring make_spring(int i, int j, const Vec3& xi, const Vec3& xj, double alpha, double stiff_ratio) {
  const Vec3 r = xj - xi;
  const double length = r.norm();
  const double softening = kSofteningShare * (length > kShortestMm ? length : 1.0);
  Spring spring{i, j, softening * softening, 0.0, {}};
  // The very expression of spring_energy, so that the force at rest is exactly zero.
  spring.rest_mm = std::sqrt(r.squaredNorm() + spring.softening_mm2);
  spring.law = {alpha,
                alpha * (stiff_ratio - 1.0),
                kCriticalShare * spring.rest_mm,
                kBandShare * spring.rest_mm};
  return spring;
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
