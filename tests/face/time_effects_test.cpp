// Effects that know time, against closed forms: inertia, viscosity, gravity.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "face/effect.h"
#include "face/energy.h"
#include "face/simulator.h"
#include "face/spring_term.h"
#include "src/base/check.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::shared_face_patch;

constexpr double kAlpha = 2.0;     // mN/mm, of a strip's springs
constexpr double kLengthMm = 5.0;  // of each

// Linear springs in a row along x, the last node on bone. Moves along x only.
class Strip {
 public:
  Strip(int num_springs, const std::vector<EffectChoice>& choices) {
    lattice_.num_free_nodes = num_springs;
    for (int k = 0; k <= num_springs; ++k) {
      lattice_.rest_mm.push_back(Vec3((num_springs - k) * kLengthMm, 0.0, 0.0));
      lattice_.mass_kg.push_back(1e-3);
    }
    for (int k = 0; k < num_springs; ++k) {
      lattice_.springs.push_back({k, k + 1, 0.0, kLengthMm, {.alpha = kAlpha}});
    }
    effects_ = make_effects(choices, anatomy_, lattice_);
    springs_ = std::make_unique<SpringTerm>(lattice_);
    state.positions_mm = lattice_.rest_mm;
  }

  double end_mm() const { return state.positions_mm[0].x() - lattice_.rest_mm[0].x(); }

  // Force that the whole strip opposes to its end, while a step lasts.
  double end_force() const { return gradient()[0]; }

  // One step in which the end goes to a place and the other nodes find theirs.
  void hold_end(double elongation_mm, double step_s, double* force = nullptr) {
    for (const auto& term : effects_.memory()) term->begin_step(state, step_s);
    state.positions_mm[0].x() = lattice_.rest_mm[0].x() + elongation_mm;
    balance(1, 0.0);
    if (force != nullptr) *force = end_force();
    for (const auto& term : effects_.memory()) term->end_step(state);
  }

  // One step under a load that pulls at the end.
  void load_end(double load_mn, double step_s) {
    for (const auto& term : effects_.memory()) term->begin_step(state, step_s);
    balance(0, load_mn);
    for (const auto& term : effects_.memory()) term->end_step(state);
  }

  FaceState state;

 private:
  class Matrix final : public HessianSink {
   public:
    explicit Matrix(int n) : value(Eigen::MatrixXd::Zero(n, n)) {}
    void add(int a, int b, const Eigen::Matrix3d& piece) override {
      const auto n = value.rows();
      if (a >= n || b >= n) return;
      value(a, b) += piece(0, 0);
      if (a != b) value(b, a) += piece(0, 0);
    }
    Eigen::MatrixXd value;
  };

  Eigen::VectorXd gradient() const {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(3 * static_cast<int>(lattice_.rest_mm.size()));
    springs_->add_gradient(state.positions_mm, g);
    for (const auto& term : effects_.energy()) term->add_gradient(state.positions_mm, g);
    return g;
  }

  // Newton's method; everything is linear here, up to rounding.
  void balance(int first, double load_mn) {
    const int n = lattice_.num_free_nodes - first;
    for (int round = 0; round < 3 && n > 0; ++round) {
      Eigen::VectorXd g(n);
      const Eigen::VectorXd all = gradient();
      for (int k = 0; k < n; ++k) g[k] = all[3 * (first + k)];
      if (first == 0) g[0] -= load_mn;
      Matrix h(lattice_.num_free_nodes);
      springs_->add_hessian(state.positions_mm, h);
      for (const auto& term : effects_.energy()) term->add_hessian(state.positions_mm, h);
      const Eigen::VectorXd step = h.value.bottomRightCorner(n, n).ldlt().solve(g);
      for (int k = 0; k < n; ++k) state.positions_mm[first + k].x() -= step[k];
    }
  }

  Anatomy anatomy_;
  Lattice lattice_;
  Effects effects_;
  std::unique_ptr<SpringTerm> springs_;
};

constexpr double kRatio = 1.5;
constexpr double kTauS = 0.4;
constexpr double kAtOnceS = 1e-7;  // a step for a jump

Strip viscous_strip(int num_springs) {
  return {num_springs, {{"viscosity", {{"ratio", kRatio}, {"relaxation_s", kTauS}}}}};
}

TEST(Viscosity, StressRelaxesAtConstantStrain) {
  for (const int n : {1, 8}) {
    Strip strip = viscous_strip(n);
    const double stretch_mm = 0.3 * n;
    const double relaxed_mn = kAlpha * stretch_mm / n;
    double force_mn = 0.0;
    strip.hold_end(stretch_mm, kAtOnceS, &force_mn);
    EXPECT_NEAR(force_mn, relaxed_mn * (1.0 + kRatio), 1e-5 * relaxed_mn);
    for (int step = 1; step <= 20; ++step) {
      strip.hold_end(stretch_mm, 0.07, &force_mn);
      const double expected = relaxed_mn * (1.0 + kRatio * std::exp(-0.07 * step / kTauS));
      EXPECT_NEAR(force_mn, expected, 1e-5 * relaxed_mn) << n << " springs, step " << step;
    }
  }
}

// Elongation at t = 1.2 tau under a constant load, against the closed form.
double creep_error(int num_springs, int num_steps) {
  const double load_mn = 0.5;
  Strip strip = viscous_strip(num_springs);
  strip.load_end(load_mn, kAtOnceS);
  const double full_mm = num_springs * load_mn / kAlpha;
  EXPECT_NEAR(strip.end_mm(), full_mm / (1.0 + kRatio), 1e-5 * full_mm);
  const double time_s = 1.2 * kTauS;
  for (int step = 0; step < num_steps; ++step) strip.load_end(load_mn, time_s / num_steps);
  const double expected =
      full_mm * (1.0 - kRatio / (1.0 + kRatio) * std::exp(-time_s / (kTauS * (1.0 + kRatio))));
  return std::abs(strip.end_mm() - expected) / full_mm;
}

TEST(Viscosity, StrainCreepsAtConstantStressInSecondOrder) {
  for (const int n : {1, 8}) {
    const double coarse = creep_error(n, 8);
    const double fine = creep_error(n, 16);
    EXPECT_LT(coarse, 2e-3);
    EXPECT_NEAR(coarse / fine, 4.0, 0.2);
  }
}

// Work lost in one cycle e0 sin(w t) once the first have passed, against the closed form.
double loop_error(int num_springs, int steps_per_cycle) {
  Strip strip = viscous_strip(num_springs);
  const double amplitude_mm = 0.4 * num_springs;
  const double w = 2.0 / kTauS;
  const double step_s = 2.0 * std::numbers::pi / w / steps_per_cycle;
  double lost = 0.0;
  double force = 0.0;
  constexpr int kCycles = 5;
  for (int step = 1; step <= kCycles * steps_per_cycle; ++step) {
    const double before_mm = strip.end_mm();
    const double force_before = force;
    strip.hold_end(amplitude_mm * std::sin(w * step * step_s), step_s, &force);
    if (step <= (kCycles - 1) * steps_per_cycle) continue;
    lost += 0.5 * (force + force_before) * (strip.end_mm() - before_mm);
  }
  const double expected = std::numbers::pi * kRatio * kAlpha / num_springs * amplitude_mm *
                          amplitude_mm * w * kTauS / (1.0 + w * w * kTauS * kTauS);
  return std::abs(lost - expected) / expected;
}

TEST(Viscosity, CyclesLoseTheAreaOfTheirLoopInSecondOrder) {
  for (const int n : {1, 8}) {
    const double coarse = loop_error(n, 32);
    const double fine = loop_error(n, 64);
    EXPECT_LT(coarse, 2e-2);
    EXPECT_NEAR(coarse / fine, 4.0, 0.3);
  }
}

TEST(Viscosity, RefusesAStateThatRemembersAnotherLattice) {
  Strip strip = viscous_strip(8);
  strip.state.history["viscosity"] = {1.0, 2.0};
  EXPECT_THROW(strip.hold_end(0.1, 0.01), InputError);
}

constexpr double kMassKg = 1e-3;  // of a node of the strip

Strip heavy_spring(double damping_per_s) {
  return {1, {{"inertia", {{"damping_per_s", damping_per_s}}}}};
}

// Damped swing of one mass on a spring, 1 s after it was let go, against the closed form.
double swing_error(int num_steps) {
  const double gamma = 6.0;
  Strip strip = heavy_spring(gamma);
  const double amplitude_mm = 1.0;
  strip.state.positions_mm[0].x() += amplitude_mm;
  for (int step = 0; step < num_steps; ++step) strip.load_end(0.0, 0.2 / num_steps);
  const double w = std::sqrt(kAlpha / kMassKg - 0.25 * gamma * gamma);
  const double expected = amplitude_mm * std::exp(-0.1 * gamma) *
                          (std::cos(0.2 * w) + 0.5 * gamma / w * std::sin(0.2 * w));
  return std::abs(strip.end_mm() - expected);
}

TEST(Inertia, MassOnASpringSwingsAsItShouldInFirstOrder) {
  const double coarse = swing_error(4000);
  EXPECT_LT(coarse, 1e-2);
  EXPECT_NEAR(coarse / swing_error(8000), 2.0, 0.1);
}

TEST(Inertia, StepIsImplicitEulerToTheLetter) {
  const double gamma = 25.0;
  const double h = 0.01;
  Strip strip = heavy_spring(gamma);
  strip.state.positions_mm[0].x() += 0.7;
  double x = 0.7;
  double v = 0.0;
  for (int step = 0; step < 50; ++step) {
    // m (v' - v) / h + gamma m v' = - alpha (x + h v')
    v = (kMassKg * v - h * kAlpha * x) / (kMassKg * (1.0 + h * gamma) + h * h * kAlpha);
    x += h * v;
    strip.load_end(0.0, h);
    ASSERT_NEAR(strip.end_mm(), x, 1e-12);
    ASSERT_NEAR(strip.state.velocities_mm_per_s[0].x(), v, 1e-10);
  }
}

TEST(Inertia, LoadAcceleratesUntilFrictionBearsIt) {
  const double gamma = 20.0;
  const Anatomy anatomy;
  Lattice lattice;
  lattice.num_free_nodes = 1;
  lattice.rest_mm = {Vec3::Zero()};
  lattice.mass_kg = {kMassKg};
  const Effects effects =
      make_effects({{"inertia", {{"damping_per_s", gamma}}}, {"gravity", {}}}, anatomy, lattice);
  FaceState state;
  state.positions_mm = lattice.rest_mm;
  for (int step = 0; step < 400; ++step) {
    for (const auto& term : effects.memory()) term->begin_step(state, 0.01);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(3);
    for (const auto& term : effects.energy()) term->add_gradient(state.positions_mm, g);
    state.positions_mm[0] -= g * (0.01 * 0.01 / (kMassKg * (1.0 + 0.01 * gamma)));
    for (const auto& term : effects.memory()) term->end_step(state);
  }
  // Lying on the back: down is -z instead of -y.
  const Vec3 expected = 9806.65 / gamma * Vec3(0.0, 1.0, -1.0);
  EXPECT_LT((state.velocities_mm_per_s[0] - expected).norm(), 1e-6 * expected.norm());
}

FacePatchOptions coarse() {
  FacePatchOptions options;
  options.half_columns = 6;
  options.row_mm = 14.0;
  options.rows_below_mouth = 3;
  options.rows_above_mouth = 9;
  return options;
}

Controls smile(const Anatomy& anatomy, double contraction) {
  Controls controls{std::vector<double>(anatomy.muscles.size(), 0.0), 0.0};
  for (const char* name : {"zygomaticus_major_L", "zygomaticus_major_R"}) {
    controls.contraction[anatomy.muscle_index(name)] = contraction;
  }
  return controls;
}

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

TissueModel with(const std::vector<EffectChoice>& more) {
  TissueModel model;
  model.effects.insert(model.effects.end(), more.begin(), more.end());
  return model;
}

TEST(Inertia, EnergyOfAFaceThatIsLetGoNeverRises) {
  const auto anatomy = shared_face_patch(coarse());
  const TissueModel model = with({{"inertia", {{"damping_per_s", 0.0}, {"mass_factor", 20.0}}}});
  SettleOptions tight;
  tight.relative_residual = 1e-9;
  Simulator simulator(anatomy, model, tight);
  FaceEnergy energy(*anatomy, model);
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(smile(*anatomy, 0.8), state).converged);
  const auto total = [&] {
    Eigen::VectorXd unused;
    double sum = energy.evaluate(state.positions_mm, unused);
    for (int k = 0; k < energy.lattice().num_free_nodes && !state.velocities_mm_per_s.empty();
         ++k) {
      sum += 10.0 * energy.lattice().mass_kg[k] * state.velocities_mm_per_s[k].squaredNorm();
    }
    return sum;
  };
  // The bone jumps back with the first step, and does work: what counts begins after it.
  ASSERT_TRUE(simulator.advance(smile(*anatomy, 0.0), 0.002, state).converged);
  double before = total();
  const double start = before;
  for (int step = 0; step < 100; ++step) {
    ASSERT_TRUE(simulator.advance(smile(*anatomy, 0.0), 0.002, state).converged) << step;
    const double now = total();
    ASSERT_LE(now, before + 1e-9 * start) << step;
    before = now;
  }
  EXPECT_GT(start, 0.0);
  EXPECT_LT(before, 0.5 * start);
}

TEST(TimeEffects, AJumpEndsInTheSameEquilibriumAtEveryRate) {
  const auto anatomy = shared_face_patch(coarse());
  SettleOptions tight;  // what is left of every step adds up in the soft motions of the tissue
  tight.relative_residual = 1e-8;
  Simulator still(anatomy, {}, tight);
  FaceState settled = still.rest();
  ASSERT_TRUE(still.settle(smile(*anatomy, 1.0), settled).converged);
  for (const double rate : {10.0, 30.0, 60.0, 240.0}) {
    Simulator simulator(anatomy, with({{"inertia", {}}, {"viscosity", {}}}), tight);
    FaceState state = simulator.rest();
    const int num_steps = static_cast<int>(8.0 * rate);
    for (int step = 0; step < num_steps; ++step) {
      ASSERT_TRUE(simulator.advance(smile(*anatomy, 1.0), 1.0 / rate, state).converged);
      if (step == 0) {
        EXPECT_GT(largest_distance(state.positions_mm, settled.positions_mm), 0.3);
      }
    }
    EXPECT_NEAR(state.time_s, 8.0, 1e-9);
    EXPECT_LT(largest_distance(state.positions_mm, settled.positions_mm), 1e-3) << rate << " Hz";
  }
}

TEST(TimeEffects, SettlingForgets) {
  const auto anatomy = shared_face_patch(coarse());
  Simulator simulator(anatomy, with({{"inertia", {}}, {"viscosity", {}}}));
  FaceState state = simulator.rest();
  simulator.advance(smile(*anatomy, 0.5), 0.02, state);
  EXPECT_FALSE(state.velocities_mm_per_s.empty());
  EXPECT_FALSE(state.history.empty());
  simulator.settle(smile(*anatomy, 0.0), state);
  EXPECT_LT(largest_distance(state.positions_mm, simulator.rest().positions_mm), 1e-6);
  EXPECT_TRUE(state.velocities_mm_per_s.empty());
  EXPECT_TRUE(state.history.empty());
}

TEST(Gravity, UprightIsTheAuthoredFaceAndTheFaceDownHeadHangsForwards) {
  const auto anatomy = shared_face_patch(coarse());
  const Controls none = smile(*anatomy, 0.0);
  Simulator upright(anatomy, with({{"gravity", {{"pitch_deg", 0.0}}}}));
  FaceState state = upright.rest();
  EXPECT_EQ(upright.settle(none, state).iterations, 0);
  EXPECT_EQ(state.positions_mm, upright.rest().positions_mm);

  const auto mean_shift = [&](double pitch_deg, double roll_deg) -> Vec3 {
    Simulator simulator(anatomy,
                        with({{"gravity", {{"pitch_deg", pitch_deg}, {"roll_deg", roll_deg}}}}));
    FaceState moved = simulator.rest();
    EXPECT_TRUE(simulator.settle(none, moved).converged);
    Vec3 sum = Vec3::Zero();
    const std::size_t n = anatomy->surface.positions_mm.size();
    for (std::size_t v = 0; v < n; ++v) {
      sum += moved.positions_mm[v] - anatomy->surface.positions_mm[v];
    }
    return sum / static_cast<double>(n);
  };
  EXPECT_GT(mean_shift(90.0, 0.0).z(), 0.0);
  EXPECT_LT(mean_shift(-90.0, 0.0).z(), 0.0);
  EXPECT_GT(mean_shift(0.0, 90.0).x(), 0.0) << "left ear down, tissue goes to the left";
  EXPECT_GT(mean_shift(180.0, 0.0).y(), 0.0) << "upside down";
}

}  // namespace
}  // namespace zygoma
