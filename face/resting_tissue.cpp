#include "face/resting_tissue.h"

#include <algorithm>
#include <cmath>

namespace zygoma {
namespace {

// Of the tolerance:
constexpr double kZoneShare = 0.6;   // what a control moves less is not in its zone
constexpr double kWakeShare = 0.4;   // a column that may be that far off wakes
constexpr double kJoinShare = 0.2;   // and with it all that may be that far off
constexpr double kForceShare = 0.4;  // by the stretch of one node alone, which is stiffer than all
constexpr double kLeaveShare = 0.2;  // a column rests if it has no further to go
constexpr double kSeenShare = 0.1;   // a control that moves no more has not moved
constexpr double kStillS = 1.0;      // a control that has not moved for that long gives its zone up
constexpr double kWorthShare = 0.85;  // of what moves: a region that is not smaller is not worth it
constexpr double kShrinkShare =
    0.85;                             // the same, on the move, where it may soon have to grow again
constexpr double kGrownShare = 0.95;  // of all, to which a region may grow before all move
constexpr int kQuestionEvery = 15;    // frames
constexpr double kWidestJaw = 0.4;    // rad, of a zone

double number_of(const std::vector<char>& region) {
  return static_cast<double>(std::count(region.begin(), region.end(), 1));
}

}  // namespace

RestingTissue::RestingTissue(FaceEnergy& energy, const ControlReach& reach, double tolerance_mm)
    : energy_(energy), reach_(reach), tolerance_mm_(tolerance_mm) {
  const std::size_t n = energy.lattice().columns.size();
  for (std::size_t k = 0; k < reach.mm.size(); ++k) {
    const double furthest = k + 1 == reach.mm.size() ? kWidestJaw : 1.0;
    std::vector<char> zone(n);
    for (std::size_t c = 0; c < n; ++c) {
      zone[c] = furthest * reach.mm[k][c] > kZoneShare * tolerance_mm;
    }
    zone_.push_back(std::move(zone));
    largest_reach_.push_back(*std::max_element(reach.mm[k].begin(), reach.mm[k].end()));
  }
  moving_.assign(n, 1);
  drift_mm_.assign(n, 0.0);
  drift_base_mm_ = drift_mm_;
  anchor_.assign(reach.mm.size(), 0.0);
  base_controls_ = anchor_;
  still_s_.assign(reach.mm.size(), kStillS);
}

double RestingTissue::moving_share() const {
  return number_of(moving_) / static_cast<double>(moving_.size());
}

void RestingTissue::wake_all(const std::vector<double>& controls, EquilibriumSolver& solver) {
  anchor_ = base_controls_ = controls;
  std::fill(still_s_.begin(), still_s_.end(), 0.0);
  if (moving_share() < 1.0) choose(std::vector<char>(moving_.size(), 1), solver);
}

// The zones of the controls that move, or have a moment ago.
std::vector<char> RestingTissue::wanted() const {
  std::vector<char> region(moving_.size(), 0);
  for (std::size_t k = 0; k < zone_.size(); ++k) {
    if (still_s_[k] >= kStillS) continue;
    for (std::size_t c = 0; c < region.size(); ++c) region[c] |= zone_[k][c];
  }
  return region;
}

void RestingTissue::choose(std::vector<char> moving, EquilibriumSolver& solver) {
  moving_ = std::move(moving);
  energy_.restrict_to_columns(moving_);
  solver.restrict_to(moving_);
  for (std::size_t c = 0; c < moving_.size(); ++c) {
    if (moving_[c]) drift_mm_[c] = 0.0;
  }
  drift_base_mm_ = drift_mm_;
  base_controls_ = anchor_;
  base_force_.clear();  // known after the next frame
  frames_to_question_ = kQuestionEvery;
}

void RestingTissue::measure_drift(const EquilibriumSolver& solver) {
  drift_mm_ = drift_base_mm_;
  for (std::size_t k = 0; k < anchor_.size(); ++k) {
    const double change = std::abs(anchor_[k] - base_controls_[k]);
    if (change == 0.0) continue;
    for (std::size_t c = 0; c < moving_.size(); ++c) drift_mm_[c] += change * reach_.mm[k][c];
  }
  const std::vector<int>& nodes = solver.resting_nodes();
  const std::vector<Vec3>& force = solver.resting_force();
  if (base_force_.empty()) base_force_ = force;
  for (std::size_t k = 0; k < base_force_.size(); ++k) {
    const int c = energy_.lattice().column_of[nodes[k]];
    const double stretch_mm = (force[k] - base_force_[k]).norm() / reach_.stiffness[c];
    if (stretch_mm > kForceShare * tolerance_mm_) drift_mm_[c] += kWakeShare * tolerance_mm_;
  }
}

void RestingTissue::follow(const std::vector<double>& controls,
                           double step_s,
                           bool at_rest,
                           EquilibriumSolver& solver) {
  for (std::size_t k = 0; k < controls.size(); ++k) {
    still_s_[k] += step_s;
    if (largest_reach_[k] * std::abs(controls[k] - anchor_[k]) <= kSeenShare * tolerance_mm_) {
      continue;
    }
    anchor_[k] = controls[k];
    still_s_[k] = 0.0;
  }
  const bool all_move = moving_share() == 1.0;
  if (all_move && !at_rest) return;
  if (!all_move) measure_drift(solver);
  std::vector<char> region(moving_.size(), 0);
  bool enough = true;
  for (std::size_t c = 0; c < region.size(); ++c) {
    enough = enough && (moving_[c] || drift_mm_[c] < kWakeShare * tolerance_mm_);
    region[c] = drift_mm_[c] > kJoinShare * tolerance_mm_;
  }
  if (!at_rest && enough) return;
  const std::vector<char> zones = wanted();
  for (std::size_t c = 0; c < region.size(); ++c) {
    region[c] = region[c] || zones[c] || (!at_rest && moving_[c]);
  }
  if (number_of(region) == 0.0) return;
  if (enough && number_of(region) > kWorthShare * number_of(moving_)) return;
  const double most = at_rest ? kWorthShare : kGrownShare;
  if (number_of(region) > most * static_cast<double>(region.size())) {
    if (all_move) return;
    std::fill(region.begin(), region.end(), 1);
  }
  choose(std::move(region), solver);
}

bool RestingTissue::could_shrink() {
  if (--frames_to_question_ > 0) return false;
  frames_to_question_ = kQuestionEvery;
  const std::vector<char> region = wanted();
  std::size_t smaller = 0;
  std::size_t now = 0;
  for (std::size_t c = 0; c < region.size(); ++c) {
    now += moving_[c];
    smaller += moving_[c] && region[c];
  }
  return smaller > 0 && static_cast<double>(smaller) <= kShrinkShare * static_cast<double>(now);
}

void RestingTissue::shrink(const std::vector<double>& left_mm, EquilibriumSolver& solver) {
  std::vector<char> region = wanted();
  for (std::size_t c = 0; c < region.size(); ++c) {
    if (region[c] || !moving_[c]) {
      region[c] = region[c] && moving_[c];
      continue;
    }
    if (left_mm[c] > kLeaveShare * tolerance_mm_) return;
  }
  choose(std::move(region), solver);
}

}  // namespace zygoma
