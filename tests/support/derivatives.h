// Random states and products with second derivatives, for holding derivatives against differences.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "face/energy_term.h"
#include "face/solvers/column_matrix.h"

namespace zygoma::test_support {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double next() { return std::uniform_real_distribution<double>(-1.0, 1.0)(engine_); }
  Vec3 vector() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }

 private:
  std::mt19937 engine_;
};

inline Eigen::VectorXd flattened(const std::vector<Vec3>& vectors) {
  Eigen::VectorXd flat(3 * vectors.size());
  for (std::size_t k = 0; k < vectors.size(); ++k) flat.segment<3>(3 * k) = vectors[k];
  return flat;
}

// Second derivatives times a motion of all nodes.
class HessianProduct final : public HessianSink {
 public:
  explicit HessianProduct(const std::vector<Vec3>& motion)
      : result(Eigen::VectorXd::Zero(3 * motion.size())), motion_(motion) {}

  void add(int a, int b, const Eigen::Matrix3d& piece) override {
    result.segment<3>(3 * a) += piece * motion_[b];
    if (a != b) result.segment<3>(3 * b) += piece.transpose() * motion_[a];
  }

  Eigen::VectorXd result;

 private:
  const std::vector<Vec3>& motion_;
};

// A matrix of columns times a vector of its unknowns.
inline Eigen::VectorXd times(const ColumnMatrix& h, const Eigen::VectorXd& x) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
  const auto unknown = [&](int column, int r) { return 3 * h.nodes[column][r / 3] + r % 3; };
  for (int c = 0; c < h.num_columns(); ++c) {
    for (int j = 0; j < h.rows(c); ++j) {
      for (int i = j; i < h.rows(c); ++i) {
        y[unknown(c, i)] += h.diagonal(c)(i, j) * x[unknown(c, j)];
        if (i != j) y[unknown(c, j)] += h.diagonal(c)(i, j) * x[unknown(c, i)];
      }
    }
  }
  for (std::size_t e = 0; e < h.edges.size(); ++e) {
    const auto [first, second] = h.edges[e];
    for (int j = 0; j < h.rows(first); ++j) {
      for (int i = 0; i < h.rows(second); ++i) {
        y[unknown(second, i)] += h.edge(e)(i, j) * x[unknown(first, j)];
        y[unknown(first, j)] += h.edge(e)(i, j) * x[unknown(second, i)];
      }
    }
  }
  return y;
}

}  // namespace zygoma::test_support
