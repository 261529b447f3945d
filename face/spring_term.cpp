#include "face/spring_term.h"

namespace zygoma {

SpringTerm::SpringTerm(const Lattice& lattice) : lattice_(lattice) {
  restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
}

double SpringTerm::add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const {
  double energy = moving_.energy_and_gradient(nodes_.at(x));
  nodes_.add_gradients(gradient);
  for (const Spring& spring : literal_) {
    Vec3 g;
    energy += spring_energy(spring, x[spring.j] - x[spring.i], g);
    gradient.segment<3>(3 * spring.i) -= g;
    gradient.segment<3>(3 * spring.j) += g;
  }
  return energy;
}

void SpringTerm::add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const {
  for (const Spring& spring : lattice_.springs) {
    if (!sink.looks_at(spring.i, spring.j)) {
      sink.skip(3);
      continue;
    }
    const Eigen::Matrix3d piece = spring_hessian(spring, x[spring.j] - x[spring.i]);
    sink.add(spring.i, spring.i, piece);
    sink.add(spring.j, spring.j, piece);
    sink.add(spring.i, spring.j, -piece);
  }
}

void SpringTerm::restrict_to(const std::vector<char>& moving) {
  std::vector<Spring> smooth;
  std::vector<char> touched(moving.size(), 0);
  literal_.clear();
  for (const Spring& spring : lattice_.springs) {
    if (!moving[spring.i] && !moving[spring.j]) continue;
    if (spring.law.law != SpringLaw::kSmooth) {
      literal_.push_back(spring);
      continue;
    }
    smooth.push_back(spring);
    touched[spring.i] = touched[spring.j] = 1;
  }
  nodes_.choose(touched);
  moving_ = SpringSet<double>(smooth, lattice_.rest_mm);
}

}  // namespace zygoma
