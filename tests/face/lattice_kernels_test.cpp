#include "face/solvers/lattice_kernels.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "face/prism.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::make_face_patch;

constexpr PrismSet::Barrier kBarrier{0.3, 3.0};

const Lattice& patch_lattice() {
  static const Lattice lattice = [] {
    FacePatchOptions options;
    options.half_columns = 5;
    options.row_mm = 16.0;
    options.rows_below_mouth = 2;
    options.rows_above_mouth = 8;
    return make_lattice(make_face_patch(options));
  }();
  return lattice;
}

// Reproducible positions around those at rest, all scaled.
std::vector<Vec3> moved(const std::vector<Vec3>& rest, double scale, double noise_mm) {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> noise(-noise_mm, noise_mm);
  std::vector<Vec3> x = rest;
  for (Vec3& p : x) {
    for (int axis = 0; axis < 3; ++axis) p[axis] = scale * p[axis] + noise(engine);
  }
  return x;
}

struct Evaluation {
  double energy = 0.0;
  std::vector<Vec3> gradient;
  double largest() const {
    double most = 0.0;
    for (const Vec3& g : gradient) most = std::max(most, g.lpNorm<Eigen::Infinity>());
    return most;
  }
};

Evaluation scalar_springs(const std::vector<Spring>& springs, const std::vector<Vec3>& x) {
  Evaluation sum{0.0, std::vector<Vec3>(x.size(), Vec3::Zero())};
  for (const Spring& spring : springs) {
    Vec3 g;
    sum.energy += spring_energy(spring, x[spring.j] - x[spring.i], g);
    sum.gradient[spring.i] -= g;
    sum.gradient[spring.j] += g;
  }
  return sum;
}

Evaluation scalar_prisms(const std::vector<Prism>& prisms, const std::vector<Vec3>& x) {
  Evaluation sum{0.0, std::vector<Vec3>(x.size(), Vec3::Zero())};
  for (const Prism& prism : prisms) {
    PrismCorners g;
    const double j = prism_volume(corners_of(prism, x), g) / prism.rest_mm3;
    const double short_of = std::max(kBarrier.start - j, 0.0);
    const double b = kBarrier.ratio * prism.bulk_kpa;
    sum.energy += prism.rest_mm3 * (0.5 * prism.bulk_kpa * (j - 1.0) * (j - 1.0) +
                                    b * short_of * short_of * short_of);
    const double first = prism.bulk_kpa * (j - 1.0) - 3.0 * b * short_of * short_of;
    for (std::size_t c = 0; c < 6; ++c) sum.gradient[prism.node[c]] += first * g[c];
  }
  return sum;
}

template <typename Set, typename Real>
Evaluation evaluate(const Set& set, const std::vector<Vec3>& x, Real) {
  std::vector<LatticeNode<Real>> nodes;
  reset_nodes(x, nodes);
  Evaluation result;
  result.energy = set.energy_and_gradient(nodes.data());
  for (const LatticeNode<Real>& node : nodes)
    result.gradient.emplace_back(node.dx, node.dy, node.dz);
  return result;
}

void expect_close(const Evaluation& actual, const Evaluation& expected, double tolerance) {
  EXPECT_NEAR(actual.energy, expected.energy, tolerance * (1e-9 + std::abs(expected.energy)));
  const double scale = 1e-9 + expected.largest();
  for (std::size_t k = 0; k < expected.gradient.size(); ++k) {
    const double off = (actual.gradient[k] - expected.gradient[k]).lpNorm<Eigen::Infinity>();
    ASSERT_LE(off, tolerance * scale) << "node " << k;
  }
}

class LatticeKernelsOf : public testing::TestWithParam<const LatticeKernels*> {
 protected:
  const LatticeKernels& kernels() const { return *GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(,
                         LatticeKernelsOf,
                         testing::ValuesIn(all_lattice_kernels()),
                         [](const auto& width) { return std::string(width.param->name); });

// As it stands, stretched beyond the critical strain, compressed, and turned inside out.
struct State {
  double scale;
  double noise_mm;
};
constexpr State kStates[] = {
    {1.0, 1e-4}, {1.0, 0.3}, {1.15, 0.3}, {1.6, 1.0}, {0.8, 0.5}, {0.1, 0.1}, {1.0, 9.0}};

TEST_P(LatticeKernelsOf, SpringsMatchTheScalarLaw) {
  const Lattice& lattice = patch_lattice();
  const SpringSet<double> springs(lattice.springs, lattice.rest_mm, kernels());
  for (const State& state : kStates) {
    SCOPED_TRACE(state.scale);
    const std::vector<Vec3> x = moved(lattice.rest_mm, state.scale, state.noise_mm);
    // Near rest elongations are differences of nearly equal lengths in either code.
    const double tolerance = state.noise_mm < 1e-3 ? 1e-8 : 1e-11;
    expect_close(evaluate(springs, x, 0.0), scalar_springs(lattice.springs, x), tolerance);
  }
}

TEST_P(LatticeKernelsOf, PrismsMatchTheScalarLaw) {
  const Lattice& lattice = patch_lattice();
  const PrismSet prisms(lattice.prisms, lattice.rest_mm, kBarrier, kernels());
  for (const State& state : kStates) {
    SCOPED_TRACE(state.scale);
    const std::vector<Vec3> x = moved(lattice.rest_mm, state.scale, state.noise_mm);
    const double tolerance = state.noise_mm < 1e-3 ? 1e-8 : 1e-11;
    expect_close(evaluate(prisms, x, 0.0), scalar_prisms(lattice.prisms, x), tolerance);
  }
}

TEST_P(LatticeKernelsOf, FloatSpringsMatchToFloatAccuracyOfStiffnessTimesLength) {
  const Lattice& lattice = patch_lattice();
  const SpringSet<float> springs(lattice.springs, lattice.rest_mm, kernels());
  double alpha_l = 0.0;  // of the stiffest node
  std::vector<double> at_node(lattice.rest_mm.size(), 0.0);
  for (const Spring& spring : lattice.springs) {
    const double beta = spring.law.alpha + spring.law.stiffening;
    at_node[spring.i] += beta * spring.rest_mm;
    at_node[spring.j] += beta * spring.rest_mm;
  }
  for (const double a : at_node) alpha_l = std::max(alpha_l, a);
  for (const State& state : kStates) {
    SCOPED_TRACE(state.scale);
    const std::vector<Vec3> x = moved(lattice.rest_mm, state.scale, state.noise_mm);
    const Evaluation actual = evaluate(springs, x, 0.0F);
    const Evaluation expected = scalar_springs(lattice.springs, x);
    // Coordinates of 100 mm are good to 4e-6 mm, some 1e-6 of a spring.
    const double limit = 2e-6 * (alpha_l + expected.largest());
    for (std::size_t k = 0; k < x.size(); ++k) {
      ASSERT_LE((actual.gradient[k] - expected.gradient[k]).lpNorm<Eigen::Infinity>(), limit);
    }
    EXPECT_NEAR(actual.energy, expected.energy, 1e-4 * expected.energy + 1e-3);
  }
}

// Elongations at, inside and at both ends of each band, far beyond, and a spring of no length.
TEST_P(LatticeKernelsOf, OneSpringThroughAllPhases) {
  const std::vector<Vec3> rest{Vec3(1.0, 2.0, 3.0), Vec3(4.0, 6.0, 3.0)};
  std::vector<Spring> laws(4, make_spring(0, 1, rest[0], rest[1], 2.0, 4.0));
  laws[1].law.stiffening = 0.0;  // without bands there is nothing to divide by
  laws[1].law.band_mm = laws[1].law.critical_mm = 0.0;
  laws[2].law.slackening = laws[2].law.slack_band_mm = 0.0;
  laws[3].law = {2.0};
  for (const Spring& law : laws) {
    const SpringSet<double> set({law}, rest, kernels());
    const double d = 0.02 * law.rest_mm;
    const double critical = 0.15 * law.rest_mm;
    for (const double e : {critical,
                           critical - d,
                           critical + d,
                           critical + 0.3 * d,
                           0.01,
                           4.0,
                           -0.01,
                           -0.15,
                           -0.3,
                           -0.5,
                           -3.0,
                           -5.0}) {
      SCOPED_TRACE(e);
      const std::vector<Vec3> x{rest[0], rest[0] + (1.0 + e / 5.0) * (rest[1] - rest[0])};
      expect_close(evaluate(set, x, 0.0), scalar_springs({law}, x), 1e-12);
    }
  }
}

TEST_P(LatticeKernelsOf, NodesThatCoincideStayFinite) {
  const std::vector<Vec3> rest{Vec3::Zero(), Vec3(2.0, 0.0, 0.0), Vec3(2.0, 1.0, 0.0)};
  Spring hard = make_spring(0, 1, rest[0], rest[1], 3.0, 4.0);
  hard.softening_mm2 = 0.0;  // of its own accord a division by zero
  hard.rest_mm = 2.0;
  const std::vector<Spring> springs{hard, make_spring(2, 1, rest[2], rest[1], 3.0, 1.0)};
  const std::vector<Vec3> x(3, Vec3::Ones());
  const Evaluation in_double = evaluate(SpringSet<double>(springs, rest, kernels()), x, 0.0);
  const Evaluation in_float = evaluate(SpringSet<float>(springs, rest, kernels()), x, 0.0F);
  EXPECT_TRUE(std::isfinite(in_double.energy));
  EXPECT_GT(in_double.energy, 0.0);
  EXPECT_TRUE(std::isfinite(in_float.energy));
  EXPECT_EQ(in_double.largest(), 0.0);
  EXPECT_EQ(in_float.largest(), 0.0);
}

TEST_P(LatticeKernelsOf, AtRestForcesAreExactlyZero) {
  const Lattice& lattice = patch_lattice();
  const std::vector<Vec3>& x = lattice.rest_mm;
  for (const auto& [energy, gradient] :
       {evaluate(SpringSet<double>(lattice.springs, x, kernels()), x, 0.0),
        evaluate(SpringSet<float>(lattice.springs, x, kernels()), x, 0.0F),
        evaluate(PrismSet(lattice.prisms, x, kBarrier, kernels()), x, 0.0)}) {
    EXPECT_EQ(energy, 0.0);
    for (const Vec3& g : gradient) EXPECT_EQ(g, Vec3::Zero());
  }
}

TEST_P(LatticeKernelsOf, ARestLengthOfItsOwnIsKept) {
  const std::vector<Vec3> x{Vec3::Zero(), Vec3(3.0, 0.0, 0.0)};
  Spring spring = make_spring(0, 1, x[0], x[1], 2.0, 1.0);
  spring.rest_mm = 2.5;
  expect_close(evaluate(SpringSet<double>({spring}, x, kernels()), x, 0.0),
               scalar_springs({spring}, x),
               1e-13);
}

// Springs without bands change their stiffness and length as if they had been made so.
TEST_P(LatticeKernelsOf, SpringsThatAreSetAnew) {
  const Lattice& lattice = patch_lattice();
  std::vector<Spring> springs = lattice.springs;
  for (Spring& spring : springs) spring.law.stiffening = spring.law.slackening = 0.0;
  SpringSet<double> set(springs, lattice.rest_mm, kernels());
  for (std::size_t k = 0; k < springs.size(); ++k) {
    springs[k].law.alpha *= 0.3;
    springs[k].rest_mm *= 0.8 + 0.05 * static_cast<double>(k % 7);
    set.set_spring(k, springs[k].law.alpha, springs[k].rest_mm);
  }
  const std::vector<Vec3> x = moved(lattice.rest_mm, 1.05, 0.4);
  expect_close(evaluate(set, x, 0.0), scalar_springs(springs, x), 1e-12);
  std::vector<LatticeNode<double>> nodes;
  reset_nodes(x, nodes);
  SimdVector<double> lengths_mm;
  set.find_lengths(nodes.data(), lengths_mm);
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const Spring& spring = springs[k];
    EXPECT_NEAR(lengths_mm[set.lane_of(k)],
                std::sqrt((x[spring.j] - x[spring.i]).squaredNorm() + spring.softening_mm2),
                1e-12);
  }
}

TEST_P(LatticeKernelsOf, SameBitsTwiceAndWithoutTheEnergy) {
  const Lattice& lattice = patch_lattice();
  const std::vector<Vec3> x = moved(lattice.rest_mm, 1.05, 0.4);
  const SpringSet<double> springs(lattice.springs, lattice.rest_mm, kernels());
  const PrismSet prisms(lattice.prisms, lattice.rest_mm, kBarrier, kernels());
  const SpringSet<double> again(lattice.springs, lattice.rest_mm, kernels());
  const Evaluation first = evaluate(springs, x, 0.0);
  const Evaluation second = evaluate(again, x, 0.0);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(first.energy),
            std::bit_cast<std::uint64_t>(second.energy));
  std::vector<LatticeNode<double>> nodes;
  reset_nodes(x, nodes);
  springs.add_gradient(nodes.data());
  for (std::size_t k = 0; k < x.size(); ++k) {
    EXPECT_EQ(first.gradient[k], second.gradient[k]);
    EXPECT_LE((Vec3(nodes[k].dx, nodes[k].dy, nodes[k].dz) - first.gradient[k]).norm(),
              1e-12 * first.largest());
  }
  EXPECT_EQ(evaluate(prisms, x, 0.0).energy, evaluate(prisms, x, 0.0).energy);
}

// Laws that do not share one shape take the other layout; a set may also hold only a few springs.
TEST_P(LatticeKernelsOf, SpringsOfDifferentShapesAndPartsOfALattice) {
  const Lattice& lattice = patch_lattice();
  const std::vector<Vec3> x = moved(lattice.rest_mm, 1.1, 0.6);
  std::vector<Spring> springs = lattice.springs;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    springs[k].law.critical_mm *= 1.0 + 0.01 * static_cast<double>(k % 5);
    if (k % 7 == 0) springs[k].law = {springs[k].law.alpha};
  }
  for (const std::size_t count : {springs.size(), std::size_t{37}, std::size_t{1}}) {
    springs.resize(count);
    const Evaluation expected = scalar_springs(springs, x);
    expect_close(
        evaluate(SpringSet<double>(springs, lattice.rest_mm, kernels()), x, 0.0), expected, 1e-11);
    const Evaluation in_float =
        evaluate(SpringSet<float>(springs, lattice.rest_mm, kernels()), x, 0.0F);
    expect_close(in_float, expected, 1e-4);
  }
  const std::vector<Prism> few(lattice.prisms.begin(), lattice.prisms.begin() + 5);
  expect_close(evaluate(PrismSet(few, lattice.rest_mm, kBarrier, kernels()), x, 0.0),
               scalar_prisms(few, x),
               1e-11);
}

TEST_P(LatticeKernelsOf, EmptySetsAreNothing) {
  const std::vector<Vec3> x(3, Vec3::Ones());
  EXPECT_EQ(evaluate(SpringSet<double>({}, x, kernels()), x, 0.0).energy, 0.0);
  EXPECT_EQ(evaluate(SpringSet<float>({}, x, kernels()), x, 0.0F).largest(), 0.0);
  EXPECT_EQ(evaluate(PrismSet({}, x, kBarrier, kernels()), x, 0.0).energy, 0.0);
  EXPECT_EQ(evaluate(SpringSet<double>(), x, 0.0).energy, 0.0);
  EXPECT_EQ(evaluate(PrismSet(), x, 0.0).energy, 0.0);
}

TEST_P(LatticeKernelsOf, WhatIsNotANumberIsNotHidden) {
  const Lattice& lattice = patch_lattice();
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<Vec3> x = lattice.rest_mm;
    x[7].y() = bad;
    EXPECT_FALSE(std::isfinite(
        evaluate(SpringSet<double>(lattice.springs, lattice.rest_mm, kernels()), x, 0.0).energy));
    EXPECT_FALSE(std::isfinite(
        evaluate(SpringSet<float>(lattice.springs, lattice.rest_mm, kernels()), x, 0.0F).energy));
    EXPECT_FALSE(std::isfinite(
        evaluate(PrismSet(lattice.prisms, lattice.rest_mm, kBarrier, kernels()), x, 0.0).energy));
  }
}

// Turning and shifting everything changes nothing inside (HC-03).
TEST_P(LatticeKernelsOf, RigidMotionLeavesNoForce) {
  const Lattice& lattice = patch_lattice();
  const Eigen::Isometry3d motion = Eigen::Translation3d(120.0, -45.0, 300.0) *
                                   Eigen::AngleAxisd(1.1, Vec3(1.0, 2.0, -0.5).normalized());
  std::vector<Vec3> x = lattice.rest_mm;
  for (Vec3& p : x) p = motion * p;
  const double scale = scalar_springs(lattice.springs, moved(lattice.rest_mm, 1.1, 0.0)).largest();
  EXPECT_LT(
      evaluate(SpringSet<double>(lattice.springs, lattice.rest_mm, kernels()), x, 0.0).largest(),
      1e-9 * scale);
  EXPECT_LT(
      evaluate(PrismSet(lattice.prisms, lattice.rest_mm, kBarrier, kernels()), x, 0.0).largest(),
      1e-9 * scale);
}

}  // namespace
}  // namespace zygoma
