// Inertia: tissue has mass, so it lags behind the bone, swings and comes to rest.
//
//   E = sum_i m_i (1 + h gamma) / (2 h^2) |x_i - y_i|^2,    y = x_n + h v_n / (1 + h gamma)
//
// over the free nodes, while a step of length h lasts. Where the sum of this and all other terms
// has its minimum, the equation of motion (paper, equation (2)) holds at the end of the step,
//
//   m (v - v_n) / h + gamma m v = forces,    v = (x - x_n) / h,
//
// which is implicit Euler: no step is too long to be stable. The price is damping of its own: a
// swing of angular frequency w loses the share h w^2 / 2 of its amplitude per second.
#include <string>

#include "face/effect.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

class Inertia final : public EnergyTerm, public MemoryTerm {
 public:
  Inertia(const EffectValues& values, const Lattice& lattice)
      : damping_per_s_(values["damping_per_s"]) {
    for (int node = 0; node < lattice.num_free_nodes; ++node) {
      mass_kg_.push_back(values["mass_factor"] * lattice.mass_kg[node]);
    }
    y_.resize(mass_kg_.size());
    restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    if (per_kg_ == 0.0) return 0.0;
    double energy = 0.0;
    for (const int k : moving_) {
      const Vec3 off = x[k] - y_[k];
      const double stiffness = per_kg_ * mass_kg_[k];
      energy += 0.5 * stiffness * off.squaredNorm();
      gradient.segment<3>(3 * k) += stiffness * off;
    }
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& /*x*/, HessianSink& sink) const override {
    for (std::size_t k = 0; k < mass_kg_.size(); ++k) {
      const int node = static_cast<int>(k);
      sink.add(node, node, (per_kg_ * mass_kg_[k]) * Eigen::Matrix3d::Identity());
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    moving_.clear();
    for (std::size_t k = 0; k < mass_kg_.size(); ++k) {
      if (moving[k]) moving_.push_back(static_cast<int>(k));
    }
  }

  void begin_step(const FaceState& state, double step_s) override {
    const std::vector<Vec3>& v = state.velocities_mm_per_s;
    require(v.empty() || v.size() == state.positions_mm.size(),
            "inertia: " + std::to_string(v.size()) + " velocities in the state, expected none or " +
                std::to_string(state.positions_mm.size()));
    step_s_ = step_s;
    const double slower = 1.0 + step_s * damping_per_s_;
    per_kg_ = slower / (step_s * step_s);
    before_ = state.positions_mm;
    for (std::size_t k = 0; k < y_.size(); ++k) {
      y_[k] = before_[k];
      if (!v.empty()) y_[k] += (step_s / slower) * v[k];
    }
  }

  void end_step(FaceState& state) override {
    std::vector<Vec3>& v = state.velocities_mm_per_s;
    v.resize(before_.size());
    for (std::size_t k = 0; k < v.size(); ++k) {
      v[k] = (state.positions_mm[k] - before_[k]) / step_s_;
    }
    per_kg_ = 0.0;
  }

 private:
  double damping_per_s_;
  std::vector<double> mass_kg_;  // of the free nodes
  std::vector<int> moving_;      // those of them that move
  // Of the step that lasts:
  double step_s_ = 0.0;
  double per_kg_ = 0.0;  // (1 + h gamma) / h^2; 0 between steps
  std::vector<Vec3> before_;
  std::vector<Vec3> y_;
};

}  // namespace

Effect make_inertia_effect() {
  Effect effect;
  effect.name = "inertia";
  effect.what = "tissue has mass: it lags, swings and comes to rest; for fast motion";
  effect.parameters = {
      {"mass_factor",
       1.0,
       0.0,
       1e4,
       "on the mass of the tissue; at 0 nothing lags, above 100 the face trails like water"},
      {"damping_per_s",
       60.0,
       0.0,
       1e4,
       "gamma / m: friction inside the tissue; below 10 it trembles, above 1000 it creeps"},
  };
  effect.called_for_when = "motion changes so fast that mass lags";
  effect.could_change_mm = [](const EffectValues& values, const ExpectedMotion& motion) {
    const double acceleration = motion.changed_mm / (motion.step_s * motion.step_s) +
                                values["damping_per_s"] * motion.moved_mm / motion.step_s;
    return values["mass_factor"] * acceleration * motion.sag_mm;
  };
  effect.internal = false;  // momentum is kept by the step, not within it
  effect.build = [](const EffectValues& values,
                    const Anatomy& /*anatomy*/,
                    const Lattice& lattice,
                    Effects& effects) { effects.file(std::make_shared<Inertia>(values, lattice)); };
  return effect;
}

}  // namespace zygoma
