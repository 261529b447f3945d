#include "face/spring_term.h"

namespace zygoma {

double SpringTerm::add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const {
  double energy = 0.0;
  for (const Spring& spring : moving_) {
    Vec3 g;
    energy += spring_energy(spring, x[spring.j] - x[spring.i], g);
    gradient.segment<3>(3 * spring.i) -= g;
    gradient.segment<3>(3 * spring.j) += g;
  }
  return energy;
}

void SpringTerm::add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const {
  for (const Spring& spring : lattice_.springs) {
    const Eigen::Matrix3d piece = spring_hessian(spring, x[spring.j] - x[spring.i]);
    sink.add(spring.i, spring.i, piece);
    sink.add(spring.j, spring.j, piece);
    sink.add(spring.i, spring.j, -piece);
  }
}

void SpringTerm::restrict_to(const std::vector<char>& moving) {
  moving_.clear();
  for (const Spring& spring : lattice_.springs) {
    if (moving[spring.i] || moving[spring.j]) moving_.push_back(spring);
  }
}

}  // namespace zygoma
