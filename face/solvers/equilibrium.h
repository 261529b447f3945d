// Finds the equilibrium of the tissue: grad E(x; controls) = 0 at a minimum of the energy. With the
// inertia of a time step among the terms of E the same minimum is that of an implicit Euler step.
//
// One loop serves cold and warm starts. Every step solves with a factored exact Hessian, corrected
// by the curvature seen since it was factored (L-BFGS):
//
//   d = - two_loop(H_factored^-1, history) grad E,     x := x + t d
//
// Right after factoring this is Newton's method. In a sequence the factor of an earlier frame still
// serves, and the first step is then the tangent prediction dx = H^-1 B dc. A new factor is paid
// for only when the steps shorten the gradient too little. Where the exact Hessian is not positive
// definite it is shifted until it is; it is never projected term by term (slower by 3-6 times on
// lattices of this kind). A step is accepted on decrease of energy, or of the gradient once energy
// differences drown in rounding: however few steps are allowed, the energy never rises. (The one
// step that is not looked back from is the last of a solve that is told how near is near enough.)
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "face/energy.h"
#include "face/solvers/factor.h"

namespace zygoma {

struct EquilibriumReport {
  bool converged = false;
  int iterations = 0;
  int factorisations = 0;
  double shift = 0.0;        // that the last Hessian needed to be positive definite; 0 = none
  double residual_mn = 0.0;  // largest force left on a node that moves
  double load_mn = 0.0;      // largest force of a muscle or the bone on the tissue
};

struct EquilibriumStop {
  double share_of_load = 1e-4;
  double least_load_mn = 0.1;
  int max_iterations = 60;
  // And no node seems to have further to go, from the way the steps got shorter: where tissue is
  // soft, next to no force is left long before it stands still.
  double way_left_mm = 0.02;
  // Or, sooner: the next step and all after it seem to take no node further than this. That step is
  // still taken, but not looked back from: the residual reported is that before it. 0 = never.
  double near_mm = 0.0;
};

// What is known of the way, each null if it is not.
struct EquilibriumHints {
  const std::vector<Vec3>* start = nullptr;  // begun from, if lower in energy than x
  const std::vector<Vec3>* ahead = nullptr;  // where x is expected half a factor's life from now
};

class EquilibriumSolver {
 public:
  // `energy` must outlive the solver.
  explicit EquilibriumSolver(const FaceEnergy& energy);

  // Only nodes of the marked columns move from now on; the energy has to be restricted alike.
  void restrict_to(const std::vector<char>& moving_columns);

  // Free nodes that do not move, and the gradient on each as far as it comes from what moves, at
  // the end of the last solve.
  const std::vector<int>& resting_nodes() const { return resting_nodes_; }
  const std::vector<Vec3>& resting_force() const { return resting_force_; }

  // Forgets what was learnt from an energy that has changed its character (not its controls).
  void forget();

  // Moves the free nodes of x until no node feels more than a share of the load, which counts as
  // least_load_mn at least, and none moves any more. On failure x is the best point reached, never
  // higher in energy than where it started. A factor that is due is made at hints.ahead.
  EquilibriumReport solve(std::vector<Vec3>& x,
                          const EquilibriumStop& stop,
                          const EquilibriumHints& hints = {});

  // Assembles the exact Hessian at x and factors it, shifted if it is not positive definite;
  // returns the shift. The attempts begin with first_shift.
  double factor_at(const std::vector<Vec3>& x, Factor& factor, double first_shift = 0.0);

  // For others to copy: its order of elimination is dear to find.
  const Factor& factor() const { return factor_; }
  // Whether it has numbers, however old.
  bool has_factor() const { return has_numbers_; }

  // As last assembled.
  const TissueHessian& hessian() const { return hessian_; }

 private:
  struct Pair {
    Eigen::VectorXd step;
    Eigen::VectorXd change;  // of the gradient
    double inverse_curvature = 0.0;
  };

  double evaluate(const std::vector<Vec3>& x, Eigen::VectorXd& gradient);
  void begin(std::vector<Vec3>& x, const std::vector<Vec3>* start);
  void refactor(const std::vector<Vec3>& x, double first_shift, EquilibriumReport& report);
  void find_direction();
  void begin_at(const std::vector<Vec3>& x);
  void place(std::vector<Vec3>& x, double share) const;
  bool search(std::vector<Vec3>& x, double& taken);
  void look_ahead(double step_mm);
  bool is_near(double near_mm, const EquilibriumReport& report) const;
  void remember(double taken, const Eigen::VectorXd& trial_gradient);

  const FaceEnergy& energy_;
  TissueHessian hessian_;
  Factor factor_;
  std::vector<int> resting_nodes_;  // free ones
  std::vector<char> moves_;         // per node
  std::vector<Vec3> resting_force_;
  std::vector<int> order_;  // of all columns: dear to find
  bool has_numbers_ = false;
  bool have_factor_ = false;
  double shift_ = 0.0;  // that it was factored with
  double solves_on_factor_ = 0.0;
  double steps_on_factor_ = 0.0;  // of those solves; the factor itself counts as kFactorSteps
  std::deque<Pair> history_;      // newest last
  // The point the loop stands on, and workspace: vectors of the nodes that move and no others, in
  // the order of the factor.
  double value_ = 0.0;
  double load_mn_ = 0.0;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd trial_gradient_;
  Eigen::VectorXd direction_;
  Eigen::VectorXd start_mm_;
  Eigen::VectorXd all_gradients_;  // of all nodes, as the energy gives them
  double step_mm_ = 0.0;           // of the node that the last step moved most
  double last_ratio_ = 0.0;        // of that step to the one before
  double slope_left_ = 0.0;        // along it, of the slope before it
  double way_left_mm_ = 0.0;       // as far as can be told
};

}  // namespace zygoma
