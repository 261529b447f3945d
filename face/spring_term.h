// The springs of the lattice as a term of the energy (paper, equation (1)): sum_k psi_k(l_k).
#pragma once

#include <vector>

#include "face/energy_term.h"
#include "face/lattice.h"
#include "face/solvers/lattice_kernels.h"

namespace zygoma {

class SpringTerm final : public EnergyTerm {
 public:
  // `lattice` must outlive the term.
  explicit SpringTerm(const Lattice& lattice);

  double add_gradient(const std::vector<Vec3>& x_mm, Eigen::VectorXd& gradient) const override;
  void add_hessian(const std::vector<Vec3>& x_mm, HessianSink& sink) const override;
  void restrict_to(const std::vector<char>& moving) override;

 private:
  const Lattice& lattice_;
  SpringSet<double> moving_;     // those with an end that moves, under the smooth law
  std::vector<Spring> literal_;  // those under the printed one: for study, one by one
  mutable TouchedNodes nodes_;   // by those under the smooth law
};

}  // namespace zygoma
