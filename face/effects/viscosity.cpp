// Viscosity (paper, section 2: stress relaxes at constant strain, strain creeps at constant stress,
// cyclic loading shows hysteresis): the ground substance slows the fibres down.
//
// Every spring gets a Maxwell branch beside it, a spring of stiffness k = ratio alpha in series
// with a dashpot of relaxation time tau, which makes it a standard linear solid. With q the part of
// the elongation e that the dashpot has not taken up yet,
//
//   force = k q,    dq/dt = de/dt - q / tau.
//
// Let e be linear in time over a step of length h. Then, without further error,
//
//   q = a q_n + b (e - e_n),    a = exp(-h / tau),    b = (1 - a) tau / h,
//
// which is the force of the potential k b / 2 (e - e*)^2 with e* = e_n - a q_n / b: exact
// derivatives, stable for every h, second order in h. q is what FaceState remembers, so that an
// empty memory stands for a face that has been at rest for long.
#include <algorithm>
#include <cmath>
#include <string>

#include "face/effect.h"
#include "face/solvers/lattice_kernels.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr const char* kName = "viscosity";
// L0 + e* is longer than the shorter of spring and dashpot, in any history that springs can have.
constexpr double kShortestMm = 1e-6;

class Viscosity final : public EnergyTerm, public MemoryTerm {
 public:
  Viscosity(const EffectValues& values, const Lattice& lattice)
      : lattice_(lattice), ratio_(values["ratio"]), relaxation_s_(values["relaxation_s"]) {
    for (const Spring& spring : lattice.springs) free_mm_.push_back(spring.rest_mm);
    restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    if (follow_ == 0.0) return 0.0;
    const double energy = branches_.energy_and_gradient(nodes_.at(x));
    nodes_.add_gradients(gradient);
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const override {
    for (std::size_t k = 0; k < free_mm_.size(); ++k) {
      const Spring& spring = lattice_.springs[k];
      if (!sink.looks_at(spring.i, spring.j)) {
        sink.skip(3);
        continue;
      }
      const Vec3 r = x[spring.j] - x[spring.i];
      const double l2 = r.squaredNorm() + spring.softening_mm2;
      const double l = std::sqrt(l2);
      const double stiffness = branch_stiffness(spring);
      const double across = stiffness * (l - free_mm_[k]) / l;
      Eigen::Matrix3d piece = ((stiffness - across) / l2) * r * r.transpose();
      piece.diagonal().array() += across;
      sink.add(spring.i, spring.i, piece);
      sink.add(spring.j, spring.j, piece);
      sink.add(spring.i, spring.j, -piece);
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    moving_.clear();
    std::vector<Spring> branches;
    std::vector<char> touched(moving.size(), 0);
    for (std::size_t k = 0; k < lattice_.springs.size(); ++k) {
      Spring spring = lattice_.springs[k];
      if (!moving[spring.i] && !moving[spring.j]) continue;
      moving_.push_back(static_cast<int>(k));
      spring.law.stiffening = spring.law.slackening = 0.0;
      branches.push_back(spring);
      touched[spring.i] = touched[spring.j] = 1;
    }
    nodes_.choose(touched);
    branches_ = SpringSet<double>(branches, lattice_.rest_mm);
    if (follow_ != 0.0) set_branches();
  }

  void begin_step(const FaceState& state, double step_s) override {
    const auto found = state.history.find(kName);
    const bool remembers = found != state.history.end() && !found->second.empty();
    require(!remembers || found->second.size() == free_mm_.size(),
            "viscosity: the state remembers " +
                std::to_string(remembers ? found->second.size() : 0) + " springs, expected " +
                std::to_string(free_mm_.size()));
    const double kept = std::exp(-step_s / relaxation_s_);
    kept_ = kept;
    follow_ = -std::expm1(-step_s / relaxation_s_) * relaxation_s_ / step_s;
    find_lengths(state.positions_mm);
    for (std::size_t n = 0; n < moving_.size(); ++n) {
      const int k = moving_[n];
      const double q = remembers ? found->second[k] : 0.0;
      free_mm_[k] = std::max(length_mm(n) - kept * q / follow_, kShortestMm);
    }
    set_branches();
  }

  void end_step(FaceState& state) override {
    std::vector<double>& q = state.history[kName];
    q.resize(free_mm_.size(), 0.0);
    // Springs that are left out keep their length.
    if (moving_.size() < q.size()) {
      for (double& left : q) left *= kept_;
    }
    find_lengths(state.positions_mm);
    for (std::size_t n = 0; n < moving_.size(); ++n) {
      q[moving_[n]] = follow_ * (length_mm(n) - free_mm_[moving_[n]]);
    }
    follow_ = 0.0;
  }

 private:
  // Of the springs that move, by place in moving_.
  void find_lengths(const std::vector<Vec3>& x) {
    branches_.find_lengths(nodes_.at(x), lengths_mm_);
  }
  double length_mm(std::size_t n) const { return lengths_mm_[branches_.lane_of(n)]; }
  void set_branches() {
    for (std::size_t n = 0; n < moving_.size(); ++n) {
      const int k = moving_[n];
      branches_.set_spring(n, branch_stiffness(lattice_.springs[k]), free_mm_[k]);
    }
  }
  double branch_stiffness(const Spring& spring) const {
    return follow_ * ratio_ * spring.law.alpha;
  }

  const Lattice& lattice_;
  double ratio_;
  double relaxation_s_;
  std::vector<int> moving_;        // springs with an end that moves
  SpringSet<double> branches_;     // of these
  mutable TouchedNodes nodes_;     // by these
  SimdVector<double> lengths_mm_;  // workspace
  // Of the step that lasts:
  double kept_ = 1.0;            // a
  double follow_ = 0.0;          // b; 0 between steps
  std::vector<double> free_mm_;  // L0 + e*, per spring
};

}  // namespace

Effect make_viscosity_effect() {
  Effect effect;
  effect.name = kName;
  effect.what = "tissue resists fast strain and creeps afterwards: softer motion, hysteresis";
  effect.parameters = {
      {"ratio",
       0.5,
       0.0,
       50.0,
       "stiffness of the slow branch against alpha; at 0 no effect, above 10 fast expressions are "
       "held back"},
      {"relaxation_s",
       0.3,
       1e-3,
       1e3,
       "time in which its tension falls to 1/e; far below a time step it has no effect, far above "
       "the length of a scene it is one more spring"},
  };
  effect.called_for_when = "tissue is strained, or has been a moment ago, faster than it creeps";
  // How far it lags when it goes on at that speed.
  effect.could_change_mm = [](const EffectValues& values, const ExpectedMotion& motion) {
    const double share = values["ratio"] / (1.0 + values["ratio"]);
    return share * values["relaxation_s"] * motion.moved_mm / motion.step_s;
  };
  effect.build = [](const EffectValues& values,
                    const Anatomy& /*anatomy*/,
                    const Lattice& lattice,
                    Effects& effects) {
    effects.file(std::make_shared<Viscosity>(values, lattice));
  };
  return effect;
}

}  // namespace zygoma
