// Tissue in time, by explicit and by implicit steps: HC-10, HC-11, HC-32.
#include <gtest/gtest.h>

#include "face/solvers/equilibrium.h"
#include "face/solvers/explicit_euler.h"
#include "src/base/check.h"
#include "tests/hard/floating_point_traps.h"
#include "tests/hard/record.h"
#include "tests/hard/scenes.h"

namespace zygoma::hard {
namespace {

using HC10 = testing::Test;  // an explosion is meant to overflow before the watchdog sees it
using HC11 = Trapped;
using HC32 = Trapped;

// Springs, masses and muscles of a patch, as an explicit system.
struct ExplicitPatch {
  Lattice lattice = make_lattice(make_face_patch(small_patch()));
  ExplicitNodes nodes;

  explicit ExplicitPatch(double damping_per_s) {
    for (std::size_t k = 0; k < lattice.rest_mm.size(); ++k) {
      nodes.mass_kg.push_back(lattice.mass_kg[k]);
      nodes.damping_kg_per_s.push_back(damping_per_s * lattice.mass_kg[k]);
      nodes.fixed.push_back(lattice.is_free(static_cast<int>(k)) ? 0 : 1);
    }
  }
  ExplicitEuler solver(const ExplicitOptions& options = {}) const {
    ExplicitEuler made(lattice.springs, lattice.rest_mm, nodes, options);
    for (const Column& column : lattice.columns) {
      made.set_velocity(column.nodes.front(), Vec3(30.0, -20.0, 10.0));
    }
    return made;
  }
};

TEST_F(HC10, StepsOfNineTenthsOfTheBoundAreStable) {
  const ExplicitPatch patch(0.0);
  ExplicitEuler solver = patch.solver();
  const int parts = 100 / repetitions(1);
  double first = 0.0;
  double highest = 0.0;
  int steps = 0;
  for (int part = 0; part < parts; ++part) {
    const ExplicitReport report = solver.advance(1000.0 * 0.9 * solver.bound_s());
    steps += report.substeps;
    ASSERT_EQ(report.restores, 0);
    ASSERT_TRUE(std::isfinite(report.energy));
    if (part == 0) first = report.energy;
    highest = std::max(highest, report.energy);
  }
  EXPECT_LT(highest, 8.0 * first);
  record("explicit steps of 0.9 of the bound, a patch let go with 37 mm/s, no damping",
         std::to_string(steps) + " steps, energy up to " + figure(highest / first) +
             " of the first look",
         "stable for 1e5 steps");
}

TEST_F(HC10, LongerStepsAreRefusedOrCaught) {
  const ExplicitPatch patch(60.0);
  ExplicitOptions options;
  options.dt_s = 3.0 * patch.solver().bound_s();
  EXPECT_THROW(patch.solver(options).advance(0.1), InputError);
  options.force_dt = true;
  ExplicitEuler forced = patch.solver(options);
  const ExplicitReport report = forced.advance(500.0 * options.dt_s);
  EXPECT_GE(report.restores, 1);
  EXPECT_FALSE(report.gave_up);
  double largest = 0.0;
  for (std::size_t k = 0; k < patch.lattice.rest_mm.size(); ++k) {
    ASSERT_TRUE(forced.positions()[k].allFinite());
    largest = std::max(largest, (forced.positions()[k] - patch.lattice.rest_mm[k]).norm());
  }
  EXPECT_LT(largest, 20.0);
  record("explicit steps of 3 times the bound, asked for and forced",
         "refused with the bound; forced: good state brought back " +
             std::to_string(report.restores) + " times, ends with steps of " +
             figure(report.dt_s / report.bound_s) + " of the bound",
         "flagged; watchdog halves and restores; never NaN");
}

TEST_F(HC11, AnImplicitStepNeverRaisesItsObjective) {
  const Anatomy anatomy = make_face_patch(coarse_patch());
  TissueModel model;
  model.effects.push_back({"inertia", {}});
  model.effects.push_back({"viscosity", {}});
  FaceEnergy energy(anatomy, model);
  const Controls controls = smile(anatomy, 0.8);
  int rises = 0;
  for (int budget = 1; budget <= 50; budget += budget < 10 ? 1 : 8) {
    EquilibriumSolver solver(energy);
    FaceState state;
    state.positions_mm = energy.lattice().rest_mm;
    for (int step = 0; step < 5; ++step) {
      energy.set_controls(controls.contraction, 0.1);
      energy.begin_step(state, 1.0 / 30.0);
      energy.place_bone(state.positions_mm);
      Eigen::VectorXd gradient;
      const double before = energy.evaluate(state.positions_mm, gradient);
      solver.solve(state.positions_mm, {1e-6, 1e-3, budget});
      const double after = energy.evaluate(state.positions_mm, gradient);
      rises += !(after <= before + 1e-12 * std::abs(before));
      energy.end_step(state);
    }
  }
  EXPECT_EQ(rises, 0);
  record("implicit steps of 33 ms with inertia and viscosity, a smile in one jump, budgets 1 to 50",
         std::to_string(rises) + " steps raised their objective",
         "never rises for any budget");
}

TEST_F(HC32, AJumpEndsInTheSameFaceAtEveryRate) {
  const auto anatomy = shared(make_face_patch(small_patch()));
  TissueModel model;
  model.effects.push_back({"inertia", {}});
  SettleOptions tight;
  tight.relative_residual = 1e-8;
  Simulator settling(anatomy, {}, tight);
  FaceState settled = settling.rest();
  EXPECT_TRUE(settling.settle(smile(*anatomy, 1.0), settled).converged);
  double worst = 0.0;
  for (const double rate : {10.0, 30.0, 60.0, 240.0}) {
    Simulator simulator(anatomy, model, tight);
    FaceState state = simulator.rest();
    for (int step = 0; step < 4.0 * rate / repetitions(1); ++step) {
      EXPECT_TRUE(simulator.advance(smile(*anatomy, 1.0), 1.0 / rate, state).converged);
    }
    worst = std::max(worst, largest_distance(state.positions_mm, settled.positions_mm));
  }
  EXPECT_LT(worst, 1e-3);
  record("a smile from 0 to 1 in one frame at 10, 30, 60 and 240 Hz, implicit steps",
         "ends within " + figure(worst) + " mm of the settled face",
         "same equilibrium to 1e-3 mm");
}

}  // namespace
}  // namespace zygoma::hard
