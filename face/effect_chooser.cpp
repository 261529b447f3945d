#include "face/effect_chooser.h"

#include <algorithm>
#include <cmath>

namespace zygoma {
namespace {

// Of the tolerance:
constexpr double kComeShare = 0.3;
constexpr double kGoShare = 0.15;
constexpr double kAgainShare = 0.6;  // a frame that missed this much is done again
constexpr double kCalmS = 0.4;       // how long an effect has to be that small before it goes: lips
                                     // that part in speech meet again with the next syllable
constexpr int kQuestionEvery = 4;    // frames: what acts need not be asked in each

}  // namespace

EffectChooser::EffectChooser(FaceEnergy& energy, double tolerance_mm)
    : energy_(energy),
      tolerance_mm_(tolerance_mm),
      uses_(energy.effects().parts().size()),
      calm_(uses_.size()) {}

void EffectChooser::come(std::size_t part) {
  energy_.set_acts(part, true);
  calm_[part].calm_s = 0.0;
}

void EffectChooser::let_all_act() {
  for (std::size_t k = 0; k < uses_.size(); ++k) {
    come(k);
    calm_[k] = {0.0, kCalmS, 0};  // what is of no use goes with the first frame
  }
}

bool EffectChooser::all_act() const {
  const std::vector<Effects::Part>& parts = energy_.effects().parts();
  return std::all_of(parts.begin(), parts.end(), [](const auto& part) { return part.acts; });
}

int EffectChooser::num_contacts() const {
  const std::vector<Effects::Part>& parts = energy_.effects().parts();
  return static_cast<int>(std::count_if(parts.begin(), parts.end(), [](const auto& part) {
    return part.acts && !part.effect->called_for_when.empty() && !part.effect->could_change_mm;
  }));
}

void EffectChooser::expect(const ExpectedMotion& motion) {
  for (std::size_t k = 0; k < uses_.size(); ++k) {
    const Effects::Part& part = energy_.effects().parts()[k];
    if (part.effect->could_change_mm == nullptr) continue;
    Calm& calm = calm_[k];
    calm.expected_mm = part.effect->could_change_mm(part.values, motion);
    if (!part.acts || calm.expected_mm > uses_[k].could_change_mm) {
      uses_[k].could_change_mm = calm.expected_mm;
    }
    if (calm.expected_mm <= kComeShare * tolerance_mm_) continue;
    if (!part.acts) come(k);
    calm.calm_s = 0.0;
  }
}

double EffectChooser::force_as_motion(std::size_t part,
                                      const std::vector<Vec3>& x,
                                      const EquilibriumSolver& solver) {
  force_.setZero(3 * energy_.num_nodes());
  energy_.add_effect_gradient(part, x, force_);
  auto motion = force_.head(energy_.num_unknowns());
  if (motion.isZero(0.0)) return 0.0;
  if (!solver.has_factor()) return tolerance_mm_;
  solver.factor().solve_roughly(motion);
  double most2 = 0.0;
  for (Eigen::Index k = 0; k < motion.size(); k += 3) {
    most2 = std::max(most2, motion.segment<3>(k).squaredNorm());
  }
  return std::sqrt(most2);
}

bool EffectChooser::accept(const std::vector<Vec3>& x,
                           double step_s,
                           const EquilibriumSolver& solver) {
  bool complete = true;
  for (std::size_t k = 0; k < uses_.size(); ++k) {
    const Effects::Part& part = energy_.effects().parts()[k];
    if (part.effect->called_for_when.empty()) continue;
    const bool by_motion = part.effect->could_change_mm != nullptr;
    Calm& calm = calm_[k];
    uses_[k].acts = part.acts;
    if (!part.acts) {
      if (by_motion) continue;
      uses_[k].could_change_mm = force_as_motion(k, x, solver);
      if (uses_[k].could_change_mm > kComeShare * tolerance_mm_) come(k);
      if (uses_[k].could_change_mm > kAgainShare * tolerance_mm_) complete = false;
      continue;
    }
    if (by_motion && calm.expected_mm > kGoShare * tolerance_mm_) {
      calm.calm_s = 0.0;
      continue;
    }
    if (calm.frames_to_question-- <= 0) {
      calm.frames_to_question = kQuestionEvery - 1;
      uses_[k].could_change_mm = force_as_motion(k, x, solver);
    }
    const bool is_calm = uses_[k].could_change_mm < kGoShare * tolerance_mm_;
    calm.calm_s = is_calm ? calm.calm_s + step_s : 0.0;
  }
  return complete;
}

void EffectChooser::dismiss(FaceState& state) {
  for (std::size_t k = 0; k < uses_.size(); ++k) {
    const Effects::Part& part = energy_.effects().parts()[k];
    if (part.effect->called_for_when.empty()) continue;
    if (!part.acts || calm_[k].calm_s < kCalmS) continue;
    energy_.set_acts(k, false);
    state.history.erase(part.effect->name);
  }
}

}  // namespace zygoma
