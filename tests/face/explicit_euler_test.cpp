#include "face/solvers/explicit_euler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "src/base/check.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::make_face_patch;

// Linear both ways, without softening.
Spring linear_spring(int i, int j, double k, double rest_mm) {
  Spring spring{i, j, 0.0, rest_mm, {}};
  spring.law.alpha = k;
  return spring;
}

ExplicitNodes alike(std::size_t n, double mass_kg, double damping) {
  return {
      std::vector<double>(n, mass_kg), std::vector<double>(n, damping), std::vector<char>(n, 0)};
}

const Lattice& small_lattice() {
  static const Lattice lattice = [] {
    FacePatchOptions options;
    options.half_columns = 3;
    options.row_mm = 26.0;
    options.rows_below_mouth = 1;
    options.rows_above_mouth = 4;
    return make_lattice(make_face_patch(options));
  }();
  return lattice;
}

ExplicitNodes nodes_of(const Lattice& lattice, double mass_kg, double damping) {
  ExplicitNodes nodes = alike(lattice.rest_mm.size(), mass_kg, damping);
  for (std::size_t k = lattice.num_free_nodes; k < nodes.fixed.size(); ++k) nodes.fixed[k] = 1;
  return nodes;
}

// Pulls some fascia nodes as a muscle would.
void pull_fascia(const Lattice& lattice, ExplicitEuler& solver, double stiffness) {
  for (int v = 0; v < lattice.num_vertices; v += 3) {
    const int node = lattice.columns[v].fascia();
    solver.set_hold(node, stiffness, lattice.rest_mm[node] + Vec3(1.5, 1.0, 0.0));
  }
}

bool all_finite(const std::vector<Vec3>& x) {
  for (const Vec3& p : x) {
    if (!p.allFinite()) return false;
  }
  return true;
}

double furthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, (a[k] - b[k]).norm());
  return most;
}

TEST(ExplicitEuler, OscillatorFollowsItsClosedForm) {
  const double k = 40.0;  // mN/mm
  const double m = 0.1;   // kg
  const double gamma = 0.4;
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(10.0, 0.0, 0.0)};
  ExplicitNodes nodes = alike(2, m, gamma);
  nodes.fixed[0] = 1;
  ExplicitOptions options;
  options.dt_s = 1e-4;
  ExplicitEuler solver({linear_spring(0, 1, k, 10.0)}, rest, nodes, options);
  solver.place(1, Vec3(11.0, 0.0, 0.0));
  const double decay = 0.5 * gamma / m;
  const double omega = std::sqrt(k / m - decay * decay);
  double time = 0.0;
  for (int frame = 0; frame < 30; ++frame) {
    const ExplicitReport report = solver.advance(1.0 / 30.0);
    time += 1.0 / 30.0;
    EXPECT_EQ(report.restores, 0);
    EXPECT_GE(report.substeps, 333);
    const double expected =
        std::exp(-decay * time) * (std::cos(omega * time) + decay / omega * std::sin(omega * time));
    EXPECT_NEAR(solver.positions()[1].x() - 10.0, expected, 2e-3);
    EXPECT_NEAR(solver.positions()[1].y(), 0.0, 1e-5);
  }
}

TEST(ExplicitEuler, PrintedOrderConvergesToTheSameMotion) {
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(10.0, 0.0, 0.0)};
  ExplicitNodes nodes = alike(2, 0.1, 2.0);
  nodes.fixed[0] = 1;
  double off[2];
  for (const int finer : {0, 1}) {
    ExplicitOptions options;
    options.literal_order = true;
    options.dt_s = finer == 1 ? 5e-5 : 1e-4;
    ExplicitEuler solver({linear_spring(0, 1, 40.0, 10.0)}, rest, nodes, options);
    solver.place(1, Vec3(11.0, 0.0, 0.0));
    solver.advance(0.1);
    const double decay = 10.0;
    const double omega = std::sqrt(400.0 - decay * decay);
    const double expected =
        std::exp(-decay * 0.1) * (std::cos(omega * 0.1) + decay / omega * std::sin(omega * 0.1));
    off[finer] = std::abs(solver.positions()[1].x() - 10.0 - expected);
  }
  EXPECT_LT(off[0], 3e-3);
  EXPECT_LT(off[1], 0.7 * off[0]);
  // Without damping it has no stable step at all.
  ExplicitOptions options;
  options.literal_order = true;
  ExplicitEuler undamped({linear_spring(0, 1, 40.0, 10.0)}, rest, alike(2, 0.1, 0.0), options);
  EXPECT_THROW(undamped.advance(0.1), InputError);
}

TEST(ExplicitEuler, StretchedSpringPullsItsEndsTogetherCompressedPushesThemApart) {  // HC-02
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(10.0, 0.0, 0.0)};
  for (const double length : {11.0, 9.0}) {
    ExplicitEuler solver({make_spring(0, 1, rest[0], rest[1], 3.0, 4.0)}, rest, alike(2, 0.1, 0.0));
    solver.place(1, Vec3(length, 0.0, 0.0));
    solver.advance(1e-3);
    const std::vector<Vec3> v = solver.velocities();
    EXPECT_GT((10.0 - length) * v[1].x(), 0.0);
    EXPECT_NEAR(v[0].x(), -v[1].x(), 1e-6 * std::abs(v[1].x()));
  }
}

TEST(ExplicitEuler, StaysExactlyPutAtRest) {  // HC-01
  const Lattice& lattice = small_lattice();
  ExplicitEuler solver(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 0.0));
  const std::vector<Vec3> before = solver.positions();
  const ExplicitReport report = solver.advance(1000.0 * 0.9 * solver.bound_s());
  EXPECT_GE(report.substeps, 1000);
  EXPECT_EQ(report.largest_speed_mm_per_s, 0.0);
  EXPECT_EQ(report.residual_mn, 0.0);
  EXPECT_EQ(furthest(solver.positions(), before), 0.0);
}

TEST(ExplicitEuler, LinearAndAngularMomentumAreKept) {  // HC-03
  const Lattice& lattice = small_lattice();
  const std::size_t n = lattice.rest_mm.size();
  ExplicitEuler solver(lattice.springs, lattice.rest_mm, alike(n, 0.5, 0.0));
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> any(-30.0, 30.0);
  for (std::size_t k = 0; k < n; ++k) {
    const double x = any(engine);
    const double y = any(engine);
    solver.set_velocity(static_cast<int>(k), Vec3(x + 20.0, y, any(engine)));
  }
  const auto momenta = [&](Vec3& linear, Vec3& angular, double& size) {
    linear = angular = Vec3::Zero();
    size = 0.0;
    const std::vector<Vec3> x = solver.positions();
    const std::vector<Vec3> v = solver.velocities();
    for (std::size_t k = 0; k < n; ++k) {
      linear += 0.5 * v[k];
      angular += 0.5 * x[k].cross(v[k]);
      size += 0.5 * v[k].norm();
    }
  };
  Vec3 p0, l0, p1, l1;
  double size = 0.0;
  momenta(p0, l0, size);
  const ExplicitReport report = solver.advance(0.5);
  EXPECT_GT(report.substeps, 10);
  EXPECT_EQ(report.restores, 0);
  momenta(p1, l1, size);
  EXPECT_LT((p1 - p0).norm(), 1e-5 * size);
  EXPECT_LT((l1 - l0).norm(), 1e-5 * size * 150.0);
}

TEST(ExplicitEuler, NineTenthsOfTheBoundAreStable) {  // HC-10
  const Lattice& lattice = small_lattice();
  ExplicitEuler solver(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 0.0));
  for (int v = 0; v < lattice.num_vertices; ++v) solver.set_velocity(v, Vec3(3.0, -2.0, 1.0));
  double first = 0.0;
  int substeps = 0;
  for (int part = 0; part < 100; ++part) {
    const ExplicitReport report = solver.advance(1000.0 * 0.9 * solver.bound_s());
    if (part == 0) first = report.energy;
    substeps += report.substeps;
    ASSERT_EQ(report.restores, 0) << part;
    ASSERT_LT(report.energy, 8.0 * first);  // ripples, but does not grow
    ASSERT_GT(report.energy, 0.0);
  }
  EXPECT_GE(substeps, 100000);
}

TEST(ExplicitEuler, ThreeTimesTheBoundIsRefusedOrCaught) {  // HC-10
  const Lattice& lattice = small_lattice();
  ExplicitOptions options;
  {
    const ExplicitEuler probe(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 2.0));
    options.dt_s = 3.0 * probe.bound_s();
  }
  ExplicitEuler refused(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 2.0), options);
  EXPECT_THROW(refused.advance(1.0), InputError);
  // Also far beyond, where float overflows between two looks of the watchdog.
  for (const double beyond : {1.0, 30.0}) {
    options.force_dt = true;
    options.dt_s *= beyond;
    ExplicitEuler forced(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 2.0), options);
    pull_fascia(lattice, forced, 20.0);
    const ExplicitReport report = forced.advance(200.0 * options.dt_s);
    EXPECT_GE(report.restores, 1);
    EXPECT_FALSE(report.gave_up);
    EXPECT_LT(report.dt_s, options.dt_s);
    EXPECT_TRUE(all_finite(forced.positions()));
    EXPECT_TRUE(all_finite(forced.velocities()));
    EXPECT_LT(furthest(forced.positions(), lattice.rest_mm), 10.0);
  }
}

TEST(ExplicitEuler, FurtherEnergyActsAndItsStiffnessCounts) {
  // Two nodes in a well each: 10 mN/mm toward x = 2.
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(10.0, 0.0, 0.0)};
  ExplicitEuler solver({linear_spring(0, 1, 1.0, 10.0)}, rest, alike(2, 0.1, 0.5));
  const double without = solver.bound_s();
  solver.set_energy(
      [](const std::vector<Vec3>& x, std::vector<Vec3>& gradient) {
        double energy = 0.0;
        for (std::size_t k = 0; k < x.size(); ++k) {
          const Vec3 off = x[k] - Vec3(k == 0 ? 2.0 : 12.0, 0.0, 0.0);
          gradient[k] += 10.0 * off;
          energy += 5.0 * off.squaredNorm();
        }
        return energy;
      },
      {10.0, 10.0});
  EXPECT_LT(solver.bound_s(), 0.6 * without);
  const ExplicitReport report = solver.advance(5.0);
  EXPECT_EQ(report.restores, 0);
  EXPECT_NEAR(solver.positions()[0].x(), 2.0, 1e-4);
  EXPECT_NEAR(solver.positions()[1].x(), 12.0, 1e-4);
  EXPECT_LT(report.residual_mn, 1e-3);
}

TEST(ExplicitEuler, HangingWeightsComeToTheSeriesOfTheirSprings) {  // HC-07
  const int n = 6;
  const double k = 50.0;
  const double weight_mn = 9.81;
  std::vector<Vec3> rest;
  std::vector<Spring> springs;
  for (int i = 0; i < n; ++i) {
    rest.emplace_back(0.0, -10.0 * i, 0.0);
    if (i > 0) springs.push_back(linear_spring(i - 1, i, k, 10.0));
  }
  ExplicitNodes nodes = alike(n, 0.2, 1.0);
  nodes.fixed[0] = 1;
  ExplicitEuler relaxed(springs, rest, nodes);
  ExplicitEuler moved(springs, rest, nodes);
  relaxed.set_outer_force(n - 1, Vec3(0.0, -weight_mn, 0.0));
  moved.set_outer_force(n - 1, Vec3(0.0, -weight_mn, 0.0));
  const RelaxReport report = relaxed.relax(1e-4, 2000);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.steps, 200);
  const ExplicitReport last = moved.advance(20.0);
  EXPECT_EQ(last.restores, 0);
  for (int i = 0; i < n; ++i) {
    const double expected = -10.0 * i - weight_mn / k * i;
    EXPECT_NEAR(relaxed.positions()[i].y(), expected, 1e-4);
    EXPECT_NEAR(moved.positions()[i].y(), expected, 1e-4);
  }
}

TEST(ExplicitEuler, RelaxingFindsTheEquilibriumThatTimeFinds) {
  constexpr double kTolerance = 1e-2;  // float carries no further; muscles pull with 90
  const Lattice& lattice = small_lattice();
  ExplicitEuler relaxed(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 10.0));
  ExplicitEuler moved(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 10.0));
  pull_fascia(lattice, relaxed, 50.0);
  pull_fascia(lattice, moved, 50.0);
  const RelaxReport report = relaxed.relax(kTolerance, 3000);
  EXPECT_TRUE(report.converged) << report.residual_mn;
  EXPECT_LT(report.steps, 600);
  ExplicitReport last;
  for (int part = 0; part < 400 && (part == 0 || last.residual_mn > kTolerance); ++part) {
    last = moved.advance(0.5);
  }
  EXPECT_LE(last.residual_mn, kTolerance);
  EXPECT_GT(furthest(relaxed.positions(), lattice.rest_mm), 1.0);
  EXPECT_LT(furthest(relaxed.positions(), moved.positions()), 0.03);
}

TEST(ExplicitEuler, FixedNodesStayWhereTheyArePut) {
  const Lattice& lattice = small_lattice();
  ExplicitEuler solver(lattice.springs, lattice.rest_mm, nodes_of(lattice, 0.5, 5.0));
  const Vec3 lifted = lattice.rest_mm[lattice.columns[4].bone()] + Vec3(0.0, 0.0, 1.0);
  solver.place(lattice.columns[4].bone(), lifted);
  solver.advance(0.5);
  EXPECT_NEAR((solver.positions()[lattice.columns[4].bone()] - lifted).norm(), 0.0, 1e-5);
  EXPECT_GT(solver.positions()[lattice.columns[4].fascia()].z(),
            lattice.rest_mm[lattice.columns[4].fascia()].z() + 1e-3);
}

TEST(ExplicitEuler, BadInputIsNamed) {
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(1.0, 0.0, 0.0)};
  const std::vector<Spring> springs{linear_spring(0, 1, 1.0, 1.0)};
  EXPECT_THROW(ExplicitEuler(springs, rest, alike(3, 1.0, 0.0)), InputError);
  EXPECT_THROW(ExplicitEuler(springs, rest, alike(2, 0.0, 0.0)), InputError);
  EXPECT_THROW(ExplicitEuler(springs, rest, alike(2, 1.0, -1.0)), InputError);
  ExplicitEuler solver(springs, rest, alike(2, 1.0, 0.0));
  EXPECT_THROW(solver.advance(std::nan("")), InputError);
  solver.place(0, Vec3(std::nan(""), 0.0, 0.0));
  EXPECT_THROW(solver.advance(1.0), InputError);
  EXPECT_THROW(solver.relax(1e-3, 10), InputError);
}

}  // namespace
}  // namespace zygoma
