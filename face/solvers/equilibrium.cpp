#include "face/solvers/equilibrium.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace zygoma {
namespace {

using Eigen::VectorXd;

constexpr std::size_t kHistory = 8;     // pairs kept by L-BFGS
constexpr int kTrialSteps = 14;         // halvings of one line search
constexpr double kLongestMoveMm = 6.0;  // of a node in one step
constexpr double kArmijo = 1e-4;
constexpr double kSmallestShift = 2.5e-4;  // of the mean diagonal; less is none
constexpr double kSlowShrink = 0.8;        // of the gradient per step: worse asks for a new factor
constexpr int kFactorSteps = 20;           // what a factor costs, in steps
constexpr int kMostSteps = 20;             // on one factor within a solve
constexpr double kFirstRatio = 0.5;        // of one step to the next, unknown yet
constexpr double kSlowestRatio = 0.95;     // steps that do not shrink count as this
constexpr double kNearShare = 1e-2;        // of the load: with more left, short steps prove nothing
constexpr int kNearSteps = 10;  // nor do they after many: tissue that snaps stalls before
constexpr int kFreshSteps = 2;  // a new factor gets at least these before it is judged

double largest_force(const Eigen::Ref<const VectorXd>& gradient) {
  double largest2 = 0.0;
  for (Eigen::Index k = 0; k + 2 < gradient.size(); k += 3) {
    largest2 = std::max(largest2, gradient.segment<3>(k).squaredNorm());
  }
  return std::sqrt(largest2);
}

}  // namespace

EquilibriumSolver::EquilibriumSolver(const FaceEnergy& energy)
    : energy_(energy),
      hessian_(energy.make_hessian()),
      factor_(hessian_.free()),
      order_(factor_.columns()) {}

void EquilibriumSolver::restrict_to(const std::vector<char>& moving_columns) {
  const Lattice& lattice = energy_.lattice();
  resting_nodes_.clear();
  moves_.assign(lattice.rest_mm.size(), 0);
  for (int node = 0; node < lattice.num_free_nodes; ++node) {
    moves_[node] = moving_columns[lattice.column_of[node]];
    if (!moves_[node]) resting_nodes_.push_back(node);
  }
  resting_force_.assign(resting_nodes_.size(), Vec3::Zero());
  std::vector<int> moving;
  for (const int c : order_) {
    if (moving_columns[c]) moving.push_back(c);
  }
  factor_ = Factor(hessian_.free(), moving);
  has_numbers_ = false;
  forget();
}

void EquilibriumSolver::forget() {
  have_factor_ = false;
  history_.clear();
}

double EquilibriumSolver::evaluate(const std::vector<Vec3>& x, VectorXd& gradient) {
  const double value = energy_.evaluate(x, all_gradients_);
  const std::vector<int>& nodes = factor_.nodes();
  gradient.resize(3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    gradient.segment<3>(3 * k) = all_gradients_.segment<3>(3 * nodes[k]);
  }
  for (std::size_t k = 0; k < resting_nodes_.size(); ++k) {
    resting_force_[k] = all_gradients_.segment<3>(3 * resting_nodes_[k]);
  }
  const auto on_bone = all_gradients_.tail(all_gradients_.size() - energy_.num_unknowns());
  load_mn_ = std::max(largest_force(on_bone), energy_.largest_muscle_force(x));
  return value;
}

double EquilibriumSolver::factor_at(const std::vector<Vec3>& x,
                                    Factor& factor,
                                    double first_shift) {
  energy_.hessian(x, hessian_);
  const ColumnMatrix& h = hessian_.free();
  double mean_diagonal = 0.0;
  for (int c = 0; c < h.num_columns(); ++c) {
    mean_diagonal += h.diagonal(c).diagonal().cwiseAbs().mean();
  }
  mean_diagonal /= h.num_columns();
  const double smallest_shift = kSmallestShift * mean_diagonal;
  double shift = first_shift < smallest_shift ? 0.0 : first_shift;
  while (!factor.compute(h, shift)) {
    shift = std::max(4.0 * smallest_shift, 4.0 * shift);
    assert(std::isfinite(shift));
  }
  return shift;
}

void EquilibriumSolver::refactor(const std::vector<Vec3>& x,
                                 double first_shift,
                                 EquilibriumReport& report) {
  hessian_.look_at(resting_nodes_.empty() ? nullptr : &moves_);
  shift_ = factor_at(x, factor_, first_shift);
  hessian_.look_at(nullptr);
  have_factor_ = has_numbers_ = true;
  solves_on_factor_ = 1.0;
  steps_on_factor_ = kFactorSteps;
  history_.clear();
  ++report.factorisations;
}

// The two-loop recursion of L-BFGS around the factor.
void EquilibriumSolver::find_direction() {
  direction_ = -gradient_;
  std::array<double, kHistory> share;
  for (std::size_t k = history_.size(); k-- > 0;) {
    const Pair& pair = history_[k];
    share[k] = pair.inverse_curvature * pair.step.dot(direction_);
    direction_ -= share[k] * pair.change;
  }
  factor_.solve_roughly_in_order(direction_);
  for (std::size_t k = 0; k < history_.size(); ++k) {
    const Pair& pair = history_[k];
    direction_ += (share[k] - pair.inverse_curvature * pair.change.dot(direction_)) * pair.step;
  }
}

void EquilibriumSolver::remember(double taken, const VectorXd& trial_gradient) {
  Pair pair;
  if (history_.size() == kHistory) {  // reuse the memory of the oldest
    pair = std::move(history_.front());
    history_.pop_front();
  }
  pair.step = taken * direction_;
  pair.change = trial_gradient - gradient_;
  const double curvature = pair.step.dot(pair.change);
  if (!(curvature > 1e-10 * pair.step.norm() * pair.change.norm())) return;
  pair.inverse_curvature = 1.0 / curvature;
  history_.push_back(std::move(pair));
}

// Steps that shrink by a ratio each have the rest of a geometric series to go.
void EquilibriumSolver::look_ahead(double step_mm) {
  const double ratio = step_mm_ > 0.0 ? std::min(step_mm / step_mm_, kSlowestRatio) : kFirstRatio;
  way_left_mm_ = step_mm * ratio / (1.0 - ratio);
  last_ratio_ = step_mm_ > 0.0 ? ratio : 0.0;
  step_mm_ = step_mm;
}

// Whether this direction and the steps after it take no node further than that. The slowest sign
// counts: the last two ratios of steps, and the share of its slope that the last step has left. A
// shifted factor does not: it hides the soft motions, which are the ones that come last.
bool EquilibriumSolver::is_near(double near_mm, const EquilibriumReport& report) const {
  if (shift_ > 0.0 || report.iterations > kNearSteps ||
      report.residual_mn > kNearShare * report.load_mn) {
    return false;
  }
  const double longest = largest_force(direction_);  // the same norm, of a motion
  const double ratio = step_mm_ > 0.0
                           ? std::max({longest / step_mm_, last_ratio_, std::abs(slope_left_)})
                           : kFirstRatio;
  return longest / (1.0 - std::min(ratio, kSlowestRatio)) <= near_mm;
}

// The point that place() goes out from.
void EquilibriumSolver::begin_at(const std::vector<Vec3>& x) {
  const std::vector<int>& nodes = factor_.nodes();
  start_mm_.resize(3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t k = 0; k < nodes.size(); ++k) start_mm_.segment<3>(3 * k) = x[nodes[k]];
}

// That share of the direction away from where it began.
void EquilibriumSolver::place(std::vector<Vec3>& x, double share) const {
  const std::vector<int>& nodes = factor_.nodes();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    x[nodes[k]] = start_mm_.segment<3>(3 * k) + share * direction_.segment<3>(3 * k);
  }
}

// Goes along the direction as far as the energy falls; false if it does not.
bool EquilibriumSolver::search(std::vector<Vec3>& x, double& taken) {
  const double slope = gradient_.dot(direction_);
  const double longest = largest_force(direction_);  // the same norm, of a motion
  if (!(slope < 0.0) || !std::isfinite(longest)) return false;
  begin_at(x);
  const double norm = gradient_.norm();
  taken = std::min(1.0, kLongestMoveMm / longest);
  for (int trial = 0; trial < kTrialSteps; ++trial, taken *= 0.5) {
    place(x, taken);
    const double value = evaluate(x, trial_gradient_);
    const bool falls = value <= value_ + kArmijo * taken * slope;
    const bool at_rounding = std::abs(taken * slope) < 1e-11 * (1.0 + std::abs(value_)) &&
                             trial_gradient_.norm() <= norm;
    if (!falls && !at_rounding) continue;
    slope_left_ = trial_gradient_.dot(direction_) / slope;
    remember(taken, trial_gradient_);
    look_ahead(taken * longest);
    value_ = value;
    gradient_.swap(trial_gradient_);
    return true;
  }
  place(x, 0.0);
  return false;
}

// From x or, if that is lower in energy, from the start that is offered.
void EquilibriumSolver::begin(std::vector<Vec3>& x, const std::vector<Vec3>* start) {
  history_.clear();
  step_mm_ = last_ratio_ = slope_left_ = way_left_mm_ = 0.0;
  value_ = evaluate(x, gradient_);
  if (!start) return;
  const double load_mn = load_mn_;
  std::vector<Vec3> resting_force = resting_force_;
  const double value = evaluate(*start, trial_gradient_);
  if (value < value_) {
    x = *start;
    value_ = value;
    gradient_.swap(trial_gradient_);
  } else {
    load_mn_ = load_mn;
    resting_force_.swap(resting_force);
  }
}

EquilibriumReport EquilibriumSolver::solve(std::vector<Vec3>& x,
                                           const EquilibriumStop& stop,
                                           const EquilibriumHints& hints) {
  EquilibriumReport report;
  begin(x, hints.start);
  const std::vector<Vec3>* ahead = hints.ahead;
  bool wants_factor = !have_factor_;
  int steps_on_factor = 0;
  int slow_steps = 0;
  double taken = 0.0;
  while (true) {
    report.residual_mn = largest_force(gradient_);
    report.load_mn = std::max(load_mn_, stop.least_load_mn);
    report.converged = report.residual_mn <= stop.share_of_load * report.load_mn &&
                       way_left_mm_ <= stop.way_left_mm;
    if (report.converged || report.iterations >= stop.max_iterations) break;
    if (wants_factor) {
      // Where a shift was needed, the next factor will want one too, unless full steps have been
      // taken since: a failed attempt costs as much as a good one.
      const bool due = report.iterations == 0 && ahead;
      refactor(due ? *ahead : x, due || taken < 1.0 ? 0.5 * shift_ : 0.0, report);
      wants_factor = false;
      steps_on_factor = slow_steps = 0;
    }
    const double before = gradient_.norm();
    find_direction();
    if (stop.near_mm > 0.0 && is_near(stop.near_mm, report)) {
      begin_at(x);
      place(x, 1.0);
      report.converged = true;
      break;
    }
    if (!search(x, taken)) {
      if (report.factorisations > (ahead ? 1 : 0) && steps_on_factor == 0) {
        break;  // Newton's own direction fails
      }
      ahead = nullptr;
      wants_factor = true;
      continue;
    }
    ++report.iterations;
    ++steps_on_factor;
    slow_steps = gradient_.norm() > kSlowShrink * before ? slow_steps + 1 : 0;
    wants_factor = steps_on_factor >= kFreshSteps &&
                   (slow_steps >= 4 || taken < 0.1 || steps_on_factor >= kMostSteps);
  }
  if (report.factorisations == 0) {
    solves_on_factor_ += 1.0;
    steps_on_factor_ += report.iterations;
    // Renewed by the next solve, where it serves from the first step on.
    have_factor_ = report.iterations <= steps_on_factor_ / solves_on_factor_;
  }
  report.shift = shift_;
  return report;
}

}  // namespace zygoma
