// Finds the equilibrium of the tissue: grad E(x; controls) = 0 at a minimum of the energy.
//
// One loop serves cold and warm starts. Every step solves with a factored exact Hessian, corrected
// by the curvature seen since it was factored (L-BFGS):
//
//   d = - two_loop(H_factored^-1, history) grad E,     x := x + t d
//
// Right after factoring this is Newton's method. In a sequence the factor of an earlier frame still
// serves, and the first step is then exactly the tangent prediction dx = H^-1 B dc. A new factor is
// paid for only when the steps shorten the gradient too little. Where the exact Hessian is not
// positive definite it is shifted until it is; it is never projected term by term (slower by 3-6
// times on lattices of this kind). A step is accepted on decrease of energy, or of the gradient
// once energy differences drown in rounding.
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "face/energy.h"
#include "face/solvers/column_matrix.h"
#include "face/solvers/factor.h"

namespace zygoma {

struct EquilibriumReport {
  bool converged = false;
  int iterations = 0;
  int factorisations = 0;
  double residual_mn = 0.0;  // largest force left on a node
};

class EquilibriumSolver {
 public:
  // `energy` must outlive the solver.
  explicit EquilibriumSolver(const FaceEnergy& energy);

  // Factors at x now, so that the first solve need not.
  void prepare(const std::vector<Vec3>& x);

  // Moves the free nodes of x until no node feels more than tolerance_mn. On failure x is the best
  // point reached, never worse in energy than where it started.
  EquilibriumReport solve(std::vector<Vec3>& x, double tolerance_mn, int max_iterations);

  // Factors the exact Hessian at x, shifted if it is not positive definite; returns the shift. The
  // attempts begin with first_shift.
  double factor_at(const std::vector<Vec3>& x, Factor& factor, double first_shift = 0.0);

  const Factor& factor() const { return factor_; }

 private:
  struct Pair {
    Eigen::VectorXd step;
    Eigen::VectorXd change;  // of the gradient
    double inverse_curvature = 0.0;
  };

  void refactor(const std::vector<Vec3>& x, double first_shift, EquilibriumReport& report);
  Eigen::VectorXd direction(const Eigen::VectorXd& gradient) const;
  bool search(std::vector<Vec3>& x, const Eigen::VectorXd& d, double& taken);
  void remember(const Eigen::VectorXd& step, const Eigen::VectorXd& change);

  const FaceEnergy& energy_;
  ColumnMatrix hessian_;
  Factor factor_;
  bool have_factor_ = false;
  double shift_ = 0.0;         // that it was factored with
  bool factor_tired_ = false;  // the last solve needed many steps on it
  std::deque<Pair> history_;
  // The point the loop stands on.
  double value_ = 0.0;
  Eigen::VectorXd gradient_;
};

}  // namespace zygoma
