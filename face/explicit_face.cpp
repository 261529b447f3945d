#include "face/explicit_face.h"

#include <algorithm>

namespace zygoma {
namespace {

constexpr int kPartsOfStep = 8;           // in which bone and muscles move during a step
constexpr double kGrownStiffness = 3.0;   // of effects, between rest and strong deformation
constexpr double kSmallestMassKg = 1e-7;  // of a node; thin tissue would ask for tiny steps

ExplicitNodes nodes_of(const Lattice& lattice, double mass_factor, double damping_per_s) {
  ExplicitNodes nodes;
  for (std::size_t k = 0; k < lattice.rest_mm.size(); ++k) {
    const double mass = std::max(kSmallestMassKg, mass_factor * lattice.mass_kg[k]);
    nodes.mass_kg.push_back(mass);
    nodes.damping_kg_per_s.push_back(damping_per_s * mass);
    nodes.fixed.push_back(lattice.is_free(static_cast<int>(k)) ? 0 : 1);
  }
  return nodes;
}

// Sum of the norms of a node's row of second derivatives: no eigenvalue is larger (Gershgorin).
class RowSums final : public HessianSink {
 public:
  explicit RowSums(std::size_t num_nodes) : sums(num_nodes, 0.0) {}
  void add(int a, int b, const Eigen::Matrix3d& piece) override {
    const double norm = piece.norm();
    sums[a] += norm;
    if (a != b) sums[b] += norm;
  }
  std::vector<double> sums;
};

}  // namespace

ExplicitFace::ExplicitFace(FaceEnergy& energy, double mass_factor, double damping_per_s)
    : energy_(energy),
      solver_(energy.lattice().springs,
              energy.lattice().rest_mm,
              nodes_of(energy.lattice(), mass_factor, damping_per_s)) {
  for (const FaceEnergy::Hold& hold : energy_.holds()) hold_target_mm_.push_back(hold.target_mm);
  if (energy_.effects().energy().empty()) return;
  RowSums rows(energy_.lattice().rest_mm.size());
  for (const auto& term : energy_.effects().energy()) {
    term->add_hessian(energy_.lattice().rest_mm, rows);
  }
  for (double& sum : rows.sums) sum *= kGrownStiffness;
  const auto add_effects = [this](const std::vector<Vec3>& x, std::vector<Vec3>& gradient) {
    gradient_.setZero(3 * energy_.num_nodes());
    double sum = 0.0;
    for (const auto& term : energy_.effects().energy()) sum += term->add_gradient(x, gradient_);
    for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] += gradient_.segment<3>(3 * k);
    return sum;
  };
  solver_.set_energy(add_effects, rows.sums);
}

void ExplicitFace::take(const FaceState& state) {
  for (std::size_t k = 0; k < state.positions_mm.size(); ++k) {
    const int node = static_cast<int>(k);
    solver_.place(node, state.positions_mm[k]);
    solver_.set_velocity(
        node, state.velocities_mm_per_s.empty() ? Vec3::Zero() : state.velocities_mm_per_s[k]);
  }
}

ExplicitReport ExplicitFace::advance(double step_s, FaceState& state) {
  take(state);
  energy_.begin_step(state, step_s);
  std::vector<Vec3> bone = state.positions_mm;
  energy_.place_bone(bone);
  ExplicitReport report;
  for (int part = 1; part <= kPartsOfStep && !report.gave_up; ++part) {
    const double share = static_cast<double>(part) / kPartsOfStep;
    for (int k = energy_.lattice().num_free_nodes; k < energy_.num_nodes(); ++k) {
      solver_.place(k, state.positions_mm[k] + share * (bone[k] - state.positions_mm[k]));
    }
    const std::vector<FaceEnergy::Hold>& holds = energy_.holds();
    for (std::size_t h = 0; h < holds.size(); ++h) {
      const Vec3& from = hold_target_mm_[h];
      solver_.set_hold(
          holds[h].node, holds[h].stiffness, from + share * (holds[h].target_mm - from));
    }
    const ExplicitReport done = solver_.advance(step_s / kPartsOfStep);
    const int substeps = report.substeps + done.substeps;
    const int restores = report.restores + done.restores;
    report = done;
    report.substeps = substeps;
    report.restores = restores;
  }
  for (std::size_t h = 0; h < energy_.holds().size(); ++h) {
    hold_target_mm_[h] = energy_.holds()[h].target_mm;
  }
  state.positions_mm = solver_.positions();
  state.velocities_mm_per_s = solver_.velocities();
  energy_.end_step(state);
  return report;
}

}  // namespace zygoma
