#include "face/energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "src/base/check.h"

namespace zygoma {

void MuscleOptions::check() const {
  require_range("muscles: hold_kpa_per_mm", hold_kpa_per_mm, 1e-3, 1e4);
  require_range("muscles: slip_hold_ratio", slip_hold_ratio, 0.0, 1e3);
  require_range("muscles: slip_elsewhere", slip_elsewhere, 0.0, 1.0);
  require_range("muscles: slip_reach_mm", slip_reach_mm, 0.1, 100.0);
  require_range("muscles: rim_hold_ratio", rim_hold_ratio, 0.0, 1e3);
}

FaceEnergy::FaceEnergy(const Anatomy& anatomy, const TissueModel& model)
    : FaceEnergy(anatomy, make_lattice(anatomy, model.lattice), model.muscles, model.effects) {}

FaceEnergy::FaceEnergy(const Anatomy& anatomy,
                       Lattice lattice,
                       const MuscleOptions& muscles,
                       const std::vector<EffectChoice>& effects)
    : anatomy_(anatomy),
      lattice_(std::move(lattice)),
      options_(muscles),
      effects_(make_effects(effects, anatomy, lattice_)),
      springs_(lattice_),
      muscles_(make_muscle_field(anatomy, lattice_)) {
  options_.check();
  find_flaps();
  find_holds();
  smooth_mandible_weight();
  set_controls(std::vector<double>(anatomy_.muscles.size(), 0.0), 0.0);
}

void FaceEnergy::find_holds() {
  std::vector<double> rim(anatomy_.cut_off.begin(), anatomy_.cut_off.end());
  rim.resize(lattice_.num_vertices, 0.0);
  for (std::size_t c = 0; c < lattice_.columns.size(); ++c) {
    holds_begin_.push_back(static_cast<int>(holds_.size()));
    const Column& column = lattice_.columns[c];
    if (!column.on_bone) continue;
    const double by_muscles =
        muscles_.hold[c] + options_.slip_hold_ratio * lattice_.below(flap_, column);
    const double by_rim = options_.rim_hold_ratio * lattice_.below(rim, column);
    for (auto node = column.nodes.rbegin() + 1; node != column.nodes.rend(); ++node) {
      double share = by_rim;
      if (*node == column.fascia() || column.is_thin()) share += by_muscles;
      if (share <= 0.0) continue;
      holds_.push_back({*node, options_.hold_kpa_per_mm * column.area_mm2 * share, Vec3::Zero()});
    }
  }
  holds_begin_.push_back(static_cast<int>(holds_.size()));
}

void FaceEnergy::set_controls(const std::vector<double>& contraction, double jaw_rad) {
  assert(contraction.size() == anatomy_.muscles.size());
  jaw_rad_ = jaw_rad;
  jaw_motion_ = open_from_closed(anatomy_.jaw, jaw_rad);
  pull_mm_.assign(lattice_.columns.size(), Vec3::Zero());
  for (std::size_t m = 0; m < contraction.size(); ++m) {
    if (contraction[m] == 0.0) continue;
    for (const MusclePull& pull : muscles_.pulls[m]) {
      pull_mm_[pull.column] += contraction[m] * pull.displacement_mm;
    }
  }
  for (Hold& hold : holds_) {
    hold.target_mm = carried(hold.node) + pull_mm_[lattice_.column_of[hold.node]];
  }
  for (const auto& term : effects_.energy()) term->follow_jaw(jaw_rad);
}

// 1 on lips and lids, fading with the distance along the skin.
void FaceEnergy::find_flaps() {
  std::vector<char> on_flap(lattice_.num_vertices, 0);
  for (int v = 0; v < lattice_.num_vertices; ++v) on_flap[v] = anatomy_.region[v] != Region::kFace;
  flap_.assign(lattice_.num_vertices, 0.0);
  if (std::find(on_flap.begin(), on_flap.end(), 1) == on_flap.end()) return;
  const std::vector<double> distance =
      distance_along(anatomy_.surface, on_flap, options_.slip_reach_mm);
  for (int v = 0; v < lattice_.num_vertices; ++v) {
    const double t = std::max(0.0, 1.0 - distance[v] / options_.slip_reach_mm);
    flap_[v] = t * t * (3.0 - 2.0 * t);
  }
}

// Soft tissue between the two bones shares their motion gently; the slit of the mouth separates.
void FaceEnergy::smooth_mandible_weight() {
  constexpr int kRounds = 6;
  mandible_weight_ = anatomy_.mandible_weight;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> mean(mandible_weight_.size());
    for (int v = 0; v < lattice_.num_vertices; ++v) {
      double sum = 0.0;
      for (const int u : lattice_.neighbors[v]) sum += mandible_weight_[u];
      mean[v] =
          0.5 * (mandible_weight_[v] + sum / static_cast<double>(lattice_.neighbors[v].size()));
    }
    mandible_weight_ = std::move(mean);
  }
}

Vec3 FaceEnergy::carried(int node) const {
  const Vec3& rest = lattice_.rest_mm[node];
  if (jaw_rad_ == 0.0) return rest;
  const double weight =
      lattice_.below(mandible_weight_, lattice_.columns[lattice_.column_of[node]]);
  return rest + weight * (jaw_motion_ * rest - rest);
}

void FaceEnergy::place_bone(std::vector<Vec3>& x) const {
  for (std::size_t c = 0; c < lattice_.columns.size(); ++c) {
    const Column& column = lattice_.columns[c];
    if (!column.on_bone) continue;
    x[column.bone()] = carried(column.bone()) + floor_slip(column) * pull_mm_[c];
  }
}

void FaceEnergy::restrict_to(const std::vector<char>& moving) {
  springs_.restrict_to(moving);
  for (const Effects::Part& part : effects_.parts()) {
    for (const auto& term : part.energy) term->restrict_to(moving);
  }
}

void FaceEnergy::restrict_to_columns(const std::vector<char>& moving) {
  std::vector<char> nodes(lattice_.rest_mm.size(), 0);
  for (int node = 0; node < lattice_.num_free_nodes; ++node) {
    nodes[node] = moving[lattice_.column_of[node]];
  }
  restrict_to(nodes);
}

double FaceEnergy::evaluate(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const {
  gradient.setZero(3 * num_nodes());
  double energy = springs_.add_gradient(x, gradient);
  for (const Hold& hold : holds_) {
    const Vec3 off = x[hold.node] - hold.target_mm;
    energy += 0.5 * hold.stiffness * off.squaredNorm();
    gradient.segment<3>(3 * hold.node) += hold.stiffness * off;
  }
  for (const auto& term : effects_.energy()) energy += term->add_gradient(x, gradient);
  return energy;
}

TissueHessian FaceEnergy::make_hessian() const {
  PatternRecorder recorder;
  add_hessian(lattice_.rest_mm, recorder);
  return {lattice_, recorder.pairs};
}

void FaceEnergy::hessian(const std::vector<Vec3>& x, TissueHessian& h) const {
  h.set_zero();
  add_hessian(x, h);
}

void FaceEnergy::add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const {
  springs_.add_hessian(x, sink);
  for (const Hold& hold : holds_) {
    sink.add(hold.node, hold.node, hold.stiffness * Eigen::Matrix3d::Identity());
  }
  for (std::size_t k = 0; k < effects_.parts().size(); ++k) {
    const Effects::Part& part = effects_.parts()[k];
    if (!part.acts) sink.skip(num_pieces_[k]);
    for (const auto& term : part.energy) {
      if (part.acts) term->add_hessian(x, sink);
    }
  }
}

void FaceEnergy::set_acts(std::size_t part, bool acts) {
  const Effects::Part& changed = effects_.parts()[part];
  if (changed.acts == acts) return;
  if (!acts) {
    PieceCounter counter;
    for (const auto& term : changed.energy) term->add_hessian(lattice_.rest_mm, counter);
    num_pieces_.resize(effects_.parts().size());
    num_pieces_[part] = counter.num_pieces;
  } else {
    for (const auto& term : changed.energy) term->follow_jaw(jaw_rad_);
  }
  effects_.set_acts(part, acts);
}

void FaceEnergy::add_effect_gradient(std::size_t part,
                                     const std::vector<Vec3>& x,
                                     Eigen::VectorXd& gradient) const {
  for (const auto& term : effects_.parts()[part].energy) {
    term->follow_jaw(jaw_rad_);
    term->add_gradient(x, gradient);
  }
}

Eigen::MatrixXd FaceEnergy::control_forces(const std::vector<Vec3>& x,
                                           const TissueHessian& h) const {
  const std::size_t num_muscles = muscles_.pulls.size();
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(num_unknowns(), num_muscles + 1);
  // What the bone does per unit of a control pulls the free nodes that are tied to it.
  std::vector<Vec3> bone_motion(num_nodes(), Vec3::Zero());
  const auto pull_by_bone = [&](Eigen::Index control) {
    for (const TissueHessian::BoneBlock& block : h.bone()) {
      const Vec3& motion = bone_motion[block.bone_node];
      if (motion.isZero(0.0)) continue;
      forces.block<3, 1>(3 * block.free_node, control) -= block.value * motion;
    }
  };
  for (std::size_t m = 0; m < num_muscles; ++m) {
    for (const MusclePull& pull : muscles_.pulls[m]) {
      const Column& column = lattice_.columns[pull.column];
      bone_motion[column.bone()] = floor_slip(column) * pull.displacement_mm;
      for (int k = holds_begin_[pull.column]; k < holds_begin_[pull.column + 1]; ++k) {
        forces.block<3, 1>(3 * holds_[k].node, m) += holds_[k].stiffness * pull.displacement_mm;
      }
    }
    pull_by_bone(m);
    for (const MusclePull& pull : muscles_.pulls[m]) {
      bone_motion[lattice_.columns[pull.column].bone()].setZero();
    }
  }
  const auto rate = [&](int node) -> Vec3 {
    return lattice_.below(mandible_weight_, lattice_.columns[lattice_.column_of[node]]) *
           opening_rate(anatomy_.jaw, jaw_rad_, lattice_.rest_mm[node]);
  };
  for (const Column& column : lattice_.columns) {
    if (column.on_bone) bone_motion[column.bone()] = rate(column.bone());
  }
  pull_by_bone(num_muscles);
  for (const Hold& hold : holds_) {
    forces.block<3, 1>(3 * hold.node, num_muscles) += hold.stiffness * rate(hold.node);
  }
  for (const auto& term : effects_.energy()) term->add_jaw_force(x, forces.col(num_muscles));
  return forces;
}

double FaceEnergy::largest_muscle_force(const std::vector<Vec3>& x) const {
  double largest2 = 0.0;
  for (const Hold& hold : holds_) {
    const double off2 = (x[hold.node] - hold.target_mm).squaredNorm();
    largest2 = std::max(largest2, hold.stiffness * hold.stiffness * off2);
  }
  return std::sqrt(largest2);
}

void FaceEnergy::begin_step(const FaceState& state, double step_s) {
  for (const auto& term : effects_.memory()) term->begin_step(state, step_s);
}

void FaceEnergy::end_step(FaceState& state) {
  for (const auto& term : effects_.memory()) term->end_step(state);
}

FaceEnergy::VolumeReport FaceEnergy::volumes(const std::vector<Vec3>& x) const {
  VolumeReport report;
  for (const Prism& prism : lattice_.prisms) {
    const double j = signed_volume(prism, x) / prism.rest_mm3;
    if (j < 0.0) ++report.inverted;
    report.mean_change += std::abs(j - 1.0);
  }
  if (!lattice_.prisms.empty()) report.mean_change /= static_cast<double>(lattice_.prisms.size());
  return report;
}

}  // namespace zygoma
