#include "face/active_region.h"

#include <algorithm>
#include <cmath>

namespace zygoma {
namespace {

// Of the tolerance: the region changes when a column that may move this far is left out, ...
constexpr double kNeededShare = 0.6;
constexpr double kMarginShare = 0.35;   // ... and takes in all from here on, to change seldom
constexpr double kLargestExcess = 1.6;  // of the region over what is needed, before it shrinks
constexpr double kForceShare = 0.4;     // of the tolerance, as the stretch a node left out may feel

}  // namespace

void ActiveRegion::restrict_all(EquilibriumSolver& solver) {
  energy_.restrict_to_columns(moving_);
  solver.restrict_to(moving_);
}

void ActiveRegion::choose(const std::vector<double>& contraction,
                          double jaw_rad,
                          double still_mm,
                          const FaceState& state,
                          EquilibriumSolver& solver) {
  if (reach_.mm.empty()) reach_ = find_control_reach(energy_, solver);
  const Lattice& lattice = energy_.lattice();
  const std::size_t n = lattice.columns.size();
  std::vector<double> reach(n, 0.0);
  for (std::size_t c = 0; c < n; ++c) {
    for (std::size_t m = 0; m < contraction.size(); ++m) {
      reach[c] += contraction[m] * reach_.mm[m][c];
    }
    reach[c] += jaw_rad * reach_.mm.back()[c];
  }
  // Where the tissue stands away from rest it has to be taken back.
  for (int node = 0; node < lattice.num_free_nodes; ++node) {
    double& r = reach[lattice.column_of[node]];
    r = std::max(r, (state.positions_mm[node] - lattice.rest_mm[node]).norm());
  }
  std::size_t wanted = 0;
  std::size_t kept = 0;
  bool enough = moving_.size() == n;
  for (std::size_t c = 0; c < n; ++c) {
    const bool need = reach[c] > kNeededShare * still_mm;
    wanted += reach[c] > kMarginShare * still_mm;
    if (moving_.size() != n) continue;
    kept += moving_[c];
    enough = enough && (moving_[c] || !need);
  }
  if (enough && static_cast<double>(kept) <= kLargestExcess * static_cast<double>(wanted) + 8.0) {
    return;
  }
  moving_.assign(n, 0);
  for (std::size_t c = 0; c < n; ++c) moving_[c] = reach[c] > kMarginShare * still_mm;
  restrict_all(solver);
}

bool ActiveRegion::grow(double still_mm, const FaceState& state, EquilibriumSolver& solver) {
  const Lattice& lattice = energy_.lattice();
  if (std::find(moving_.begin(), moving_.end(), 0) == moving_.end()) return false;
  energy_.restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
  Eigen::VectorXd gradient;
  energy_.evaluate(state.positions_mm, gradient);
  std::vector<char> grown = moving_;
  for (int node = 0; node < lattice.num_free_nodes; ++node) {
    const int c = lattice.column_of[node];
    if (moving_[c]) continue;
    if (gradient.segment<3>(3 * node).norm() > kForceShare * still_mm * reach_.stiffness[c])
      grown[c] = 1;
  }
  const bool changed = grown != moving_;
  moving_ = std::move(grown);
  energy_.restrict_to_columns(moving_);
  if (changed) solver.restrict_to(moving_);
  return changed;
}

void ActiveRegion::release(EquilibriumSolver& solver) {
  if (moving_share() == 1.0) return;
  moving_.assign(moving_.size(), 1);
  restrict_all(solver);
}

double ActiveRegion::moving_share() const {
  if (moving_.empty()) return 1.0;
  return static_cast<double>(std::count(moving_.begin(), moving_.end(), 1)) /
         static_cast<double>(moving_.size());
}

}  // namespace zygoma
