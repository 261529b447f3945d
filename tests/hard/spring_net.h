// A few springs with weights on their nodes, in equilibrium by Newton's method on dense matrices:
// the laws of the springs against closed forms, apart from lattice and solvers.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "face/lattice.h"
#include "face/spring_term.h"

namespace zygoma::hard {

class DenseHessian final : public HessianSink {
 public:
  explicit DenseHessian(std::size_t num_nodes)
      : matrix(Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes)) {}
  void add(int a, int b, const Eigen::Matrix3d& piece) override {
    matrix.block<3, 3>(3 * a, 3 * b) += piece;
    if (a != b) matrix.block<3, 3>(3 * b, 3 * a) += piece.transpose();
  }
  Eigen::MatrixXd matrix;
};

struct SpringNet {
  Lattice lattice;              // nodes that move first
  std::vector<Vec3> weight_mn;  // per node
  int most_steps = 100;

  // Moves x to where springs and weights balance; the largest force that is left.
  double settle(std::vector<Vec3>& x) const {
    const SpringTerm springs(lattice);
    const Eigen::Index n = 3 * lattice.num_free_nodes;
    const auto forces = [&](const std::vector<Vec3>& at, Eigen::VectorXd& gradient) {
      gradient.setZero(3 * at.size());
      double energy = springs.add_gradient(at, gradient);
      for (std::size_t k = 0; k < at.size(); ++k) {
        gradient.segment<3>(3 * k) -= weight_mn[k];
        energy -= weight_mn[k].dot(at[k]);
      }
      gradient.conservativeResize(n);
      return energy;
    };
    Eigen::VectorXd gradient;
    double energy = forces(x, gradient);
    for (int step = 0; step < most_steps && gradient.lpNorm<Eigen::Infinity>() > 1e-10; ++step) {
      DenseHessian h(x.size());
      springs.add_hessian(x, h);
      Eigen::MatrixXd free = h.matrix.topLeftCorner(n, n);
      free.diagonal().array() += 1e-9;  // a chain is free to turn about itself
      const Eigen::VectorXd direction = -free.ldlt().solve(gradient);
      const std::vector<Vec3> start = x;
      double taken = 1.0;
      for (int halving = 0; halving < 30; ++halving, taken *= 0.5) {
        for (Eigen::Index k = 0; k < n / 3; ++k)
          x[k] = start[k] + taken * direction.segment<3>(3 * k);
        const double value = forces(x, gradient);
        if (value > energy + 1e-14 * std::abs(energy)) continue;
        energy = value;
        break;
      }
    }
    return gradient.lpNorm<Eigen::Infinity>();
  }
};

// Springs one below the other from a fixed point, each of this length and stiffness.
inline SpringNet hanging_chain(int num_springs,
                               double length_mm,
                               double alpha,
                               double stiff_ratio) {
  SpringNet net;
  Lattice& lattice = net.lattice;
  lattice.num_free_nodes = num_springs;
  for (int k = 1; k <= num_springs; ++k) lattice.rest_mm.emplace_back(0.0, -k * length_mm, 0.0);
  lattice.rest_mm.push_back(Vec3::Zero());
  for (int k = 0; k < num_springs; ++k) {
    const int above = k == 0 ? num_springs : k - 1;
    lattice.springs.push_back(
        make_spring(k, above, lattice.rest_mm[k], lattice.rest_mm[above], alpha, stiff_ratio));
  }
  net.weight_mn.assign(lattice.rest_mm.size(), Vec3::Zero());
  return net;
}

}  // namespace zygoma::hard
