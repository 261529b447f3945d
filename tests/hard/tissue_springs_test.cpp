// Springs, volumes and their derivatives: HC-02 to HC-07.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>

#include "face/effect.h"
#include "face/solvers/factor.h"
#include "face/spring_term.h"
#include "src/base/check.h"
#include "tests/hard/floating_point_traps.h"
#include "tests/hard/record.h"
#include "tests/hard/scenes.h"
#include "tests/hard/spring_net.h"

namespace zygoma::hard {
namespace {

using test_support::flattened;
using test_support::HessianProduct;

using HC02 = Trapped;
using HC03 = Trapped;
using HC04 = Trapped;
using HC05 = Trapped;
using HC06 = Trapped;
using HC07 = Trapped;

TEST_F(HC02, EndsOfAStretchedSpringApproachOfACompressedOneSeparate) {
  Lattice lattice;
  lattice.rest_mm = {Vec3::Zero(), Vec3(6.0, 8.0, 0.0)};
  lattice.num_free_nodes = 2;
  lattice.springs = {make_spring(0, 1, lattice.rest_mm[0], lattice.rest_mm[1], 3.0, 4.0)};
  const SpringTerm term(lattice);
  const Vec3 along = lattice.rest_mm[1].normalized();
  for (const double stretch_mm : {1.0, 4.0, -1.0, -6.0}) {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(6);
    term.add_gradient({Vec3::Zero(), lattice.rest_mm[1] + stretch_mm * along}, gradient);
    const Vec3 on_first = -gradient.head<3>();
    const Vec3 on_second = -gradient.tail<3>();
    EXPECT_EQ(on_first, -on_second);
    EXPECT_GT(on_first.dot(along) * stretch_mm, 0.0) << stretch_mm;
    EXPECT_LT(on_first.cross(along).norm(), 1e-13 * on_first.norm());
  }
  record("one spring, stretched by 1 and 4 of 10 mm, compressed by 1 and 6",
         "equal and opposite to the bit; ends approach, separate",
         "forces equal and opposite; ends approach / separate");
}

// Forces of everything in a face that acts between nodes only.
Eigen::VectorXd internal_forces(const SpringTerm& springs,
                                const Effects& effects,
                                const std::vector<Vec3>& x) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * x.size());
  springs.add_gradient(x, gradient);
  for (const auto& term : effects.energy()) term->add_gradient(x, gradient);
  return gradient;
}

struct RigidErrors {
  double turned = 0.0;  // relative to the largest force
  double turned_far = 0.0;
  double shifted_far = 0.0;
  double total_force = 0.0;
  double total_torque = 0.0;
};

RigidErrors rigid_errors(const Tissue& tissue, unsigned seed) {
  const Anatomy anatomy = make_face_patch(coarse_patch());
  Lattice lattice = make_lattice(anatomy, tissue.model.lattice);
  const Effects effects = make_effects({{"volume", {}}}, anatomy, lattice);
  const SpringTerm springs(lattice);
  Random random(seed);
  // On a grid of 2^-30 mm, so that a shift by whole millimetres makes no rounding error.
  constexpr double kGrid = 1.0 / (1 << 30);
  std::vector<Vec3> x = lattice.rest_mm;
  for (Vec3& p : x) {
    p += random.vector();
    p = kGrid * (p / kGrid).array().round().matrix();
  }
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(3.0 * random.next(), random.vector().normalized()).toRotationMatrix();
  const Eigen::VectorXd f = internal_forces(springs, effects, x);
  const double largest = f.lpNorm<Eigen::Infinity>();
  RigidErrors errors;
  const auto change = [&](const Eigen::Matrix3d& rotation, const Vec3& shift_mm) {
    std::vector<Vec3> moved = x;
    for (Vec3& p : moved) p = rotation * p + shift_mm;
    const Eigen::VectorXd g = internal_forces(springs, effects, moved);
    double worst = 0.0;
    for (Eigen::Index k = 0; k < f.size(); k += 3) {
      worst = std::max(worst, (g.segment<3>(k) - rotation * f.segment<3>(k)).norm());
    }
    return worst / largest;
  };
  errors.turned = change(turn, 100.0 * random.vector());
  errors.turned_far = change(turn, Vec3(1e6, -1e6, 1e6));
  errors.shifted_far = change(Eigen::Matrix3d::Identity(), Vec3(1e6, -1e6, 1e6));
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
  for (std::size_t k = 0; k < x.size(); ++k) {
    force += f.segment<3>(3 * k);
    torque += x[k].cross(f.segment<3>(3 * k).eval());
  }
  errors.total_force = force.norm() / largest;
  errors.total_torque = torque.norm() / (largest * 100.0);
  return errors;
}

TEST_F(HC03, RigidMotionDoesNotChangeInternalForces) {
  RigidErrors worst;
  for (const Tissue& tissue : topologies()) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(tissue.name + ", seed " + std::to_string(seed));
      const RigidErrors errors = rigid_errors(tissue, seed);
      EXPECT_LT(errors.turned, 1e-9);
      EXPECT_LT(errors.shifted_far, 1e-9);
      EXPECT_LT(errors.turned_far, 1e-7);
      EXPECT_LT(errors.total_force, 1e-9);
      EXPECT_LT(errors.total_torque, 1e-9);
      worst.turned = std::max(worst.turned, errors.turned);
      worst.turned_far = std::max(worst.turned_far, errors.turned_far);
      worst.shifted_far = std::max(worst.shifted_far, errors.shifted_far);
      worst.total_force = std::max(worst.total_force, errors.total_force);
      worst.total_torque = std::max(worst.total_torque, errors.total_torque);
    }
  }
  record("random rotation and shift by 100 mm, three topologies, 5 seeds",
         "forces change by " + figure(worst.turned) + "; sum of forces " +
             figure(worst.total_force) + ", of torques " + figure(worst.total_torque),
         "< 1e-9 relative");
  record("shift by 1e6 mm; the same with a rotation, where positions are rounded to 1e-10 mm",
         "forces change by " + figure(worst.shifted_far) + "; " + figure(worst.turned_far),
         "< 1e-9; < 1e-7 (what rounding of the input allows)");
}

struct Mismatch {
  double first = 0.0;   // of the gradient, against differences of the energy
  double second = 0.0;  // of the Hessian, against differences of the gradient
};

// One term along a random direction around x. Where it has no force its error counts against
// `least_mn`.
Mismatch mismatch(const EnergyTerm& term,
                  int num_free_nodes,
                  const std::vector<Vec3>& x,
                  double h,
                  Random& random,
                  double least_mn = 1e-9) {
  std::vector<Vec3> motion(x.size());
  for (Vec3& m : motion) m = random.vector();
  const auto at = [&](double step, Eigen::VectorXd& gradient) {
    std::vector<Vec3> moved = x;
    for (std::size_t k = 0; k < x.size(); ++k) moved[k] += step * motion[k];
    gradient = Eigen::VectorXd::Zero(3 * x.size());
    return term.add_gradient(moved, gradient);
  };
  Eigen::VectorXd g, forward, backward;
  at(0.0, g);
  const double rise = (at(h, forward) - at(-h, backward)) / (2.0 * h);
  HessianProduct product(motion);
  term.add_hessian(x, product);
  // Of the free nodes: how forces of bone on bone change, nobody asks.
  const Eigen::VectorXd expected = ((forward - backward) / (2.0 * h)).head(3 * num_free_nodes);
  const Eigen::VectorXd flat = flattened(motion);
  const double slope_scale = std::max(least_mn, g.norm()) * flat.norm();
  return {
      std::abs(rise - g.dot(flat)) / slope_scale,
      (product.result.head(expected.size()) - expected).norm() / std::max(1e-9, expected.norm())};
}

// Rest positions scaled and shaken: moved, compressed, inside out.
std::vector<Vec3> shaken(const std::vector<Vec3>& rest, double scale, double mm, Random& random) {
  std::vector<Vec3> x = rest;
  for (Vec3& p : x) p = scale * p + mm * random.vector();
  return x;
}

TEST_F(HC04, EveryTermMatchesCentralDifferences) {
  const Anatomy anatomy = make_face_patch(small_patch());
  Mismatch worst;
  int num_terms = 0;
  for (const Tissue& tissue : topologies()) {
    Lattice lattice = make_lattice(anatomy, tissue.model.lattice);
    std::vector<std::pair<std::string, std::shared_ptr<EnergyTerm>>> terms;
    std::vector<Effects> keep;
    for (const Effect& effect : all_effects()) {
      keep.push_back(make_effects({{effect.name, {}}}, anatomy, lattice));
      FaceState state;
      state.positions_mm = lattice.rest_mm;
      for (const auto& term : keep.back().memory()) term->begin_step(state, 1.0 / 60.0);
      for (const auto& term : keep.back().energy()) terms.emplace_back(effect.name, term);
    }
    // After the effects, which may have changed the springs.
    terms.emplace_back("springs", std::make_shared<SpringTerm>(lattice));
    for (const auto& [name, term] : terms) {
      ++num_terms;
      for (unsigned seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const double noise_mm = std::array{0.1, 1.0, 4.0, 12.0}[seed % 4];
        const std::vector<Vec3> x =
            shaken(lattice.rest_mm, seed % 2 == 0 ? 1.0 : 0.6, noise_mm, random);
        const Mismatch off = mismatch(*term, lattice.num_free_nodes, x, 1e-5, random);
        EXPECT_LT(off.first, 1e-6) << tissue.name << ", " << name << ", seed " << seed;
        EXPECT_LT(off.second, 1e-5) << tissue.name << ", " << name << ", seed " << seed;
        worst.first = std::max(worst.first, off.first);
        worst.second = std::max(worst.second, off.second);
      }
    }
  }
  record("springs and every effect, three topologies, 20 random states up to inside out",
         std::to_string(num_terms) + " terms: gradient off by " + figure(worst.first) +
             ", Hessian by " + figure(worst.second),
         "accuracy of the differences: 1e-6, 1e-5");
}

TEST_F(HC04, ASpringIsSmoothAtTheEndsOfItsBandsAndDownToLengthZero) {
  Lattice lattice;
  lattice.rest_mm = {Vec3::Zero(), Vec3(10.0, 0.0, 0.0)};
  lattice.num_free_nodes = 2;
  lattice.springs = {make_spring(0, 1, lattice.rest_mm[0], lattice.rest_mm[1], 3.0, 10.0)};
  const Spring& spring = lattice.springs[0];
  const SpringTerm term(lattice);
  const double e_c = spring.law.critical_mm;
  const double d = spring.law.band_mm;
  const double slack = spring.law.slack_band_mm;
  Mismatch worst;
  const auto check = [&](double length_mm) {
    Random random(5);
    const Vec3 along = Vec3(0.6, 0.0, 0.8);
    const Mismatch off =
        mismatch(term, 2, {Vec3::Zero(), length_mm * along}, 2e-7, random, spring.law.alpha);
    EXPECT_LT(off.first, 1e-5) << length_mm;
    EXPECT_LT(off.second, 1e-5) << length_mm;
    worst.first = std::max(worst.first, off.first);
    worst.second = std::max(worst.second, off.second);
  };
  for (const double e : {e_c - d, e_c, e_c + d, 0.0, -slack, -2.0 * slack}) {
    const double l = spring.rest_mm + e;  // with the softening
    check(std::sqrt(l * l - spring.softening_mm2));
  }
  for (const double length_mm : {1e-2, 1e-4, 1e-8, 0.0}) check(length_mm);
  record("one spring, elongation exactly e_c, e_c +- d and the ends of the slack band; length to 0",
         "gradient off by " + figure(worst.first) + ", Hessian by " + figure(worst.second),
         "accuracy of the differences: 1e-5");
}

TEST_F(HC05, CoincidentAndDuplicateSpringsHaveFiniteForces) {
  Lattice lattice;
  lattice.rest_mm = {Vec3::Ones(), Vec3::Ones(), Vec3(5.0, 1.0, 1.0)};
  lattice.num_free_nodes = 3;
  lattice.springs = {make_spring(0, 1, lattice.rest_mm[0], lattice.rest_mm[1], 3.0, 1e6),
                     make_spring(0, 2, lattice.rest_mm[0], lattice.rest_mm[2], 3.0, 4.0)};
  Eigen::VectorXd once = Eigen::VectorXd::Zero(9);
  const std::vector<Vec3> x{Vec3(2.0, 0.0, 0.0), Vec3(2.0, 0.0, 0.0), Vec3(2.0, 0.0, 0.0)};
  EXPECT_TRUE(std::isfinite(SpringTerm(lattice).add_gradient(x, once)));
  EXPECT_TRUE(once.allFinite());
  DenseHessian h(3);
  SpringTerm(lattice).add_hessian(x, h);
  EXPECT_TRUE(h.matrix.allFinite());
  // Twice the same springs: twice the forces.
  std::vector<Vec3> moved = x;
  moved[1] += Vec3(0.5, 0.2, 0.0);
  moved[2] += Vec3(5.0, 0.0, 0.0);
  once.setZero();
  SpringTerm(lattice).add_gradient(moved, once);
  lattice.springs.insert(lattice.springs.end(), {lattice.springs[0], lattice.springs[1]});
  Eigen::VectorXd twice = Eigen::VectorXd::Zero(9);
  SpringTerm(lattice).add_gradient(moved, twice);
  EXPECT_EQ(twice, (2.0 * once).eval());
  record("spring of length 0 at rest and now, springs twice",
         "finite; twice the force",
         "finite forces");
}

TEST_F(HC05, AnIsolatedNodeIsReported) {
  Anatomy anatomy = make_face_patch(small_patch());
  anatomy.surface.positions_mm.push_back(Vec3::Zero());
  anatomy.tissue_depth_mm.push_back(9.0);
  anatomy.mandible_weight.push_back(0.0);
  anatomy.region.push_back(Region::kFace);
  const std::string name =
      "surface vertex " + std::to_string(anatomy.surface.positions_mm.size() - 1);
  try {
    make_lattice(anatomy);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
  }
  // The same node in a matrix: no factor, instead of a motion made up.
  ColumnMatrix h;
  h.reset({{0}, {1}}, {});
  for (int k = 0; k < 3; ++k) h.values[4 * k] = 2.0;  // the first node only
  EXPECT_FALSE(Factor(h).compute(h, 0.0));
  record("a vertex without triangle; a singular matrix",
         "the vertex is named; the factor says it is not positive definite",
         "reported, not silently moved",
         Outcome::kRefused);
}

TEST_F(HC06, AHangingWeightFindsItsPlaceAlsoBetweenAlphaAndBeta) {
  SpringNet net = hanging_chain(1, 20.0, 3.0, 10.0);
  const BiphasicLaw& law = net.lattice.springs[0].law;
  const double soft = law.alpha * law.critical_mm;
  const double stiff = (law.alpha + law.stiffening) * law.critical_mm;
  std::vector<Vec3> x = net.lattice.rest_mm;
  double before = 0.0;
  double largest_step = 0.0;
  double largest_left = 0.0;
  constexpr int kSteps = 400;
  const double per_step = 1.5 * stiff / kSteps;
  for (int step = 1; step <= kSteps; ++step) {
    net.weight_mn[0] = Vec3(0.0, -step * per_step, 0.0);
    largest_left = std::max(largest_left, net.settle(x));
    const double sunk = net.lattice.rest_mm[0].y() - x[0].y();
    EXPECT_GT(sunk, before);
    largest_step = std::max(largest_step, sunk - before);
    before = sunk;
  }
  // Continuous: no step is longer than the softest stiffness allows.
  EXPECT_LT(largest_step, 1.01 * per_step / law.alpha);
  EXPECT_LT(largest_left, 1e-9);
  record("a weight of 0 to 1.5 beta e_c in 400 steps on a smooth spring, beta = 10 alpha",
         "sinks at every step, by at most " + figure(largest_step * law.alpha / per_step) +
             " of what alpha allows; force left " + figure(largest_left) + " mN",
         "displacement continuous and monotone");
  // The printed law: nothing balances a weight between the two.
  net.lattice.springs[0] = literal_spring(net.lattice.springs[0]);
  double smallest_left = 1e30;
  for (const double share : {0.1, 0.5, 0.9}) {
    x = net.lattice.rest_mm;
    net.weight_mn[0] = Vec3(0.0, -(soft + share * (stiff - soft)), 0.0);
    smallest_left = std::min(smallest_left, net.settle(x));
    const double length = std::sqrt(x[0].squaredNorm() + net.lattice.springs[0].softening_mm2);
    EXPECT_NEAR(length - net.lattice.springs[0].rest_mm, law.critical_mm, 1e-6);
  }
  EXPECT_GT(smallest_left, 0.05 * (stiff - soft));
  record("the same on a spring of the printed law, weights between alpha e_c and beta e_c",
         "hangs at e_c with at least " + figure(smallest_left) + " mN unbalanced (gap " +
             figure(stiff - soft) + ")",
         "detected as not convergent",
         Outcome::kRefused);
}

TEST_F(HC06, AFaceOfThePrintedLawIsReportedAsNotConverged) {
  const auto anatomy = shared(make_face_patch(small_patch()));
  for (const Tissue& tissue : topologies()) {
    SCOPED_TRACE(tissue.name);
    TissueModel model = tissue.model;
    for (TissueLayer& layer : model.lattice.layers) layer.stiff_ratio = 10.0;
    const auto settle = [&](SpringLaw law, FaceState& state) {
      model.lattice.law = law;
      Simulator simulator(anatomy, model);
      state = simulator.rest();
      return simulator.settle(smile(*anatomy, 1.0), state);
    };
    FaceState smooth_state;
    EXPECT_TRUE(settle(SpringLaw::kSmooth, smooth_state).converged);
    FaceState state;
    const SettleReport report = settle(SpringLaw::kLiteral, state);
    EXPECT_FALSE(report.converged);
    // Why: springs stand at the jump itself, where no force between the two is to be had.
    int at_jump = 0;
    for (const Spring& spring : make_lattice(*anatomy, model.lattice).springs) {
      const Vec3 r = state.positions_mm[spring.j] - state.positions_mm[spring.i];
      const double e = std::sqrt(r.squaredNorm() + spring.softening_mm2) - spring.rest_mm;
      at_jump += spring.law.stiffening > 0.0 && std::abs(e - spring.law.critical_mm) < 1e-2;
    }
    EXPECT_GT(at_jump, 0);
    for (const Vec3& p : state.positions_mm) ASSERT_TRUE(p.allFinite());
    record("smile at 1 on a face of the printed law, beta = 10 alpha, " + tissue.name,
           "stops at " + figure(report.residual) + " of the load with " + std::to_string(at_jump) +
               " springs within 10 um of the jump",
           "reported as not converged; finite",
           Outcome::kRefused);
  }
}

TEST_F(HC07, SpringsInSeriesAndInParallelFollowTheClosedForm) {
  constexpr int kSprings = 12;
  constexpr double kWeight = 5.0;
  const auto sunk = [&](double alpha, int parallel) {
    SpringNet net = hanging_chain(kSprings, 20.0, alpha, 1.0);
    const std::vector<Spring> chain = net.lattice.springs;
    for (int k = 1; k < parallel; ++k) {
      net.lattice.springs.insert(net.lattice.springs.end(), chain.begin(), chain.end());
    }
    net.weight_mn[kSprings - 1] = Vec3(0.0, -kWeight, 0.0);
    std::vector<Vec3> x = net.lattice.rest_mm;
    EXPECT_LT(net.settle(x), 1e-9);
    return net.lattice.rest_mm[kSprings - 1].y() - x[kSprings - 1].y();
  };
  const double one = sunk(3.0, 1);
  const double closed = kSprings * kWeight / 3.0;
  const double series = std::abs(one / closed - 1.0);
  const double parallel = std::abs(4.0 * sunk(3.0, 4) / one - 1.0);
  const double stiffer = std::abs(4.0 * sunk(12.0, 1) / one - 1.0);
  EXPECT_LT(series, 1e-3);  // the softened length
  EXPECT_LT(parallel, 1e-3);
  EXPECT_LT(stiffer, 1e-3);
  record(
      "12 springs in series; four in parallel; stiffness x 4",
      "off the closed form by " + figure(series) + ", " + figure(parallel) + ", " + figure(stiffer),
      "closed form, strain / 4; 1e-3 for the softened length");
}

}  // namespace
}  // namespace zygoma::hard
