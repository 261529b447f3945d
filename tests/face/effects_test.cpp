// What every effect has to stand, whichever it is: the suite runs over all_effects(), so that an
// effect is tested by existing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>

#include "face/effect.h"
#include "face/energy.h"
#include "src/base/check.h"
#include "tests/support/allocations.h"
#include "tests/support/derivatives.h"
#include "tests/support/face_patch.h"
#include "tests/support/instructions.h"

namespace zygoma {

// How GoogleTest shows a parameter.
void PrintTo(const Effect& effect, std::ostream* out) { *out << effect.name; }

namespace {

using test_support::FacePatchOptions;
using test_support::flattened;
using test_support::HessianProduct;
using test_support::make_face_patch;
using test_support::Random;

constexpr double kStepS = 1.0 / 60.0;

Anatomy small_patch() {
  FacePatchOptions options;
  options.half_columns = 5;
  options.row_mm = 16.0;
  options.rows_below_mouth = 2;
  options.rows_above_mouth = 8;
  Anatomy anatomy = make_face_patch(options);
  // Rows of teeth right behind the mouth.
  anatomy.teeth = {{27.0, 33.0, -7.0, -77.0, 14.0}, {25.0, 31.0, -8.0, -75.0, 14.0}};
  return anatomy;
}

// A face with one effect.
struct Scene {
  explicit Scene(const EffectChoice& choice, Topology topology = Topology::kPrisms)
      : anatomy(small_patch()), energy(anatomy, model(choice, topology)) {}

  static TissueModel model(const EffectChoice& choice, Topology topology) {
    TissueModel tissue;
    tissue.lattice.topology = topology;
    tissue.effects = {choice};
    return tissue;
  }
  const Lattice& lattice() const { return energy.lattice(); }

  std::vector<Vec3> random_positions(unsigned seed, double noise_mm) const {
    Random random(seed);
    std::vector<Vec3> x = lattice().rest_mm;
    for (Vec3& p : x) p = 0.9 * p + noise_mm * random.vector();
    return x;
  }

  FaceState at_rest() const {
    FaceState state;
    state.positions_mm = lattice().rest_mm;
    return state;
  }

  void set_jaw(double jaw_rad) {
    energy.set_controls(std::vector<double>(anatomy.muscles.size(), 0.0), jaw_rad);
  }

  // A step from rest to a place, and the beginning of another: what has a memory is awake now.
  void wake(const std::vector<Vec3>& place) {
    FaceState state = at_rest();
    energy.begin_step(state, kStepS);
    state.positions_mm = place;
    energy.end_step(state);
    energy.begin_step(state, kStepS);
  }

  // Of the effect alone.
  double gradient(const std::vector<Vec3>& x, Eigen::VectorXd& g) const {
    g.setZero(3 * static_cast<Eigen::Index>(x.size()));
    double sum = 0.0;
    for (const auto& term : energy.effects().energy()) sum += term->add_gradient(x, g);
    return sum;
  }
  void hessian(const std::vector<Vec3>& x, HessianSink& sink) const {
    for (const auto& term : energy.effects().energy()) term->add_hessian(x, sink);
  }

  Anatomy anatomy;
  FaceEnergy energy;
};

// Values for which the face at rest is at rest: gravity acts on any other than an upright head.
EffectChoice restful(const Effect& effect) {
  if (effect.name == "gravity") return {effect.name, {{"pitch_deg", 0.0}}};
  return {effect.name, {}};
}

class EveryEffect : public testing::TestWithParam<Effect> {
 protected:
  const Effect& effect() const { return GetParam(); }
  EffectChoice usual() const { return {effect().name, {}}; }

  // The message with which a choice is refused.
  static std::string refusal(const std::vector<EffectChoice>& choices) {
    try {
      check_effects(choices);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_P(EveryEffect, SaysWhatItIs) {
  EXPECT_FALSE(effect().what.empty());
  EXPECT_TRUE(effect().shape != nullptr || effect().build != nullptr);
  for (const EffectParameter& p : effect().parameters) {
    EXPECT_LT(p.lowest, p.highest) << p.name;
    EXPECT_GE(p.usual, p.lowest) << p.name;
    EXPECT_LE(p.usual, p.highest) << p.name;
    EXPECT_FALSE(p.help.empty()) << p.name;
  }
}

TEST_P(EveryEffect, RefusesWhatItCannotTake) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const EffectParameter& p : effect().parameters) {
    for (const double bad : {p.lowest - 1.0, p.highest + 1.0, kNan, kInfinity}) {
      const std::string message = refusal({{effect().name, {{p.name, bad}}}});
      for (const std::string& part : {effect().name,
                                      p.name,
                                      shortest_text(bad),
                                      shortest_text(p.lowest),
                                      shortest_text(p.highest)}) {
        EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
      }
    }
    for (const double good : {p.lowest, p.usual, p.highest}) {
      EXPECT_EQ(refusal({{effect().name, {{p.name, good}}}}), "");
    }
  }
  EXPECT_NE(refusal({{effect().name, {{"flavour", 1.0}}}}).find("flavour"), std::string::npos);
  EXPECT_NE(refusal({usual(), usual()}).find("twice"), std::string::npos);
}

TEST_P(EveryEffect, LeavesTheFaceAtRestAlone) {
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    Scene scene(restful(effect()), topology);
    const std::vector<Vec3>& rest = scene.lattice().rest_mm;
    Eigen::VectorXd g;
    EXPECT_EQ(scene.energy.evaluate(rest, g), 0.0);
    EXPECT_EQ(g.lpNorm<Eigen::Infinity>(), 0.0);
    scene.wake(rest);
    EXPECT_EQ(scene.energy.evaluate(rest, g), 0.0);
    EXPECT_EQ(g.lpNorm<Eigen::Infinity>(), 0.0);
  }
}

TEST_P(EveryEffect, InternalForcesAndTorquesAddUpToZero) {
  if (!effect().internal) GTEST_SKIP() << "acts from outside";
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    Scene scene(usual(), topology);
    scene.wake(scene.random_positions(1, 3.0));
    const std::vector<Vec3> x = scene.random_positions(2, 5.0);
    Eigen::VectorXd g;
    scene.gradient(x, g);
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    double scale = 0.0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const Vec3 f = -g.segment<3>(3 * k);
      force += f;
      torque += x[k].cross(f);
      scale += f.norm();
    }
    EXPECT_LE(force.norm(), 1e-12 * scale);
    EXPECT_LE(torque.norm(), 1e-10 * scale);
  }
}

TEST_P(EveryEffect, DerivativesMatchCentralDifferences) {
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    // Gently moved, folded, and turned inside out here and there.
    for (const double noise_mm : {0.3, 3.0, 9.0}) {
      SCOPED_TRACE("topology " + std::to_string(static_cast<int>(topology)) + ", noise " +
                   std::to_string(noise_mm));
      Scene scene(usual(), topology);
      scene.set_jaw(0.1);
      scene.wake(scene.random_positions(5, noise_mm));
      const std::vector<Vec3> x = scene.random_positions(6, noise_mm);
      Random random(7);
      std::vector<Vec3> motion(x.size());
      for (Vec3& m : motion) m = random.vector();
      const auto moved = [&](double by) {
        std::vector<Vec3> result = x;
        for (std::size_t k = 0; k < x.size(); ++k) result[k] += by * motion[k];
        return result;
      };
      const Eigen::Index n = scene.energy.num_unknowns();
      const double h = 1e-5;
      Eigen::VectorXd g, gf, gb;
      scene.gradient(x, g);
      scene.gradient(moved(+h), gf);
      scene.gradient(moved(-h), gb);
      if (noise_mm > 5.0 && !scene.energy.effects().energy().empty()) {
        EXPECT_GT(g.norm(), 0.0) << "nothing to be seen of the effect";
      }
      const Eigen::VectorXd expected = ((gf - gb) / (2 * h)).head(n);
      HessianProduct product(motion);
      scene.hessian(x, product);
      EXPECT_LE((product.result.head(n) - expected).norm(), 1e-5 * expected.norm() + 1e-9);
      // The energy, along the free nodes alone: bone has no complete gradient.
      for (int k = 0; k < scene.energy.num_nodes(); ++k) {
        if (!scene.lattice().is_free(k)) motion[k].setZero();
      }
      const double slope =
          (scene.gradient(moved(+h), gf) - scene.gradient(moved(-h), gb)) / (2 * h);
      EXPECT_NEAR(
          slope, g.dot(flattened(motion)), 1e-6 * g.norm() * flattened(motion).norm() + 1e-9);
    }
  }
}

TEST_P(EveryEffect, JawForceMatchesCentralDifferences) {
  Scene scene(usual());
  const std::vector<Vec3> x = scene.random_positions(8, 2.0);
  const Eigen::Index n = scene.energy.num_unknowns();
  for (const double jaw_rad : {0.0, 0.2}) {
    scene.set_jaw(jaw_rad);
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(n);
    for (const auto& term : scene.energy.effects().energy()) term->add_jaw_force(x, forces);
    const double h = 1e-6;
    Eigen::VectorXd gf, gb;
    scene.set_jaw(jaw_rad + h);
    scene.gradient(x, gf);
    scene.set_jaw(jaw_rad - h);
    scene.gradient(x, gb);
    const Eigen::VectorXd expected = -((gf - gb) / (2 * h)).head(n);
    EXPECT_LE((forces - expected).norm(), 1e-5 * expected.norm() + 1e-9);
  }
}

TEST_P(EveryEffect, SameBitsTwice) {
  std::array<Eigen::VectorXd, 3> g;
  std::array<double, 3> value{};
  Scene one(usual());
  Scene other(usual());
  const std::vector<Vec3> place = one.random_positions(9, 2.0);
  const std::vector<Vec3> x = one.random_positions(10, 3.0);
  one.wake(place);
  other.wake(place);
  value[0] = one.energy.evaluate(x, g[0]);
  value[1] = one.energy.evaluate(x, g[1]);
  value[2] = other.energy.evaluate(x, g[2]);
  for (const int k : {1, 2}) {
    EXPECT_EQ(value[0], value[k]);
    EXPECT_EQ(g[0], g[k]);
  }
}

TEST_P(EveryEffect, PatternIsTheSameWhereverTheNodesAre) {
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    Scene scene(usual(), topology);
    PatternRecorder at_rest;
    scene.hessian(scene.lattice().rest_mm, at_rest);
    scene.wake(scene.random_positions(11, 2.0));
    scene.set_jaw(0.3);
    PatternRecorder elsewhere;
    scene.hessian(scene.random_positions(12, 9.0), elsewhere);
    EXPECT_EQ(at_rest.pairs, elsewhere.pairs);
  }
}

TEST_P(EveryEffect, AllocatesNothingWhileItIsEvaluated) {
  if (!test_support::can_count_allocations) GTEST_SKIP() << "a sanitizer counts already";
  Scene scene(usual());
  scene.wake(scene.random_positions(13, 2.0));
  const std::vector<Vec3> x = scene.random_positions(14, 3.0);
  Eigen::VectorXd g;
  scene.gradient(x, g);
  TissueHessian hessian = scene.energy.make_hessian();
  long before = test_support::num_allocations;
  scene.gradient(x, g);
  scene.energy.hessian(x, hessian);
  EXPECT_EQ(test_support::num_allocations, before);
  before = test_support::num_allocations;
  const Eigen::VectorXd copy = g;
  EXPECT_EQ(copy.size(), g.size());
  EXPECT_GT(test_support::num_allocations, before) << "the counter does not count";
}

// For every node the one across the middle of the face.
std::vector<int> twins(const Scene& scene) {
  const Anatomy& anatomy = scene.anatomy;
  const Lattice& lattice = scene.lattice();
  std::vector<int> twin(lattice.rest_mm.size());
  for (std::size_t v = 0; v < anatomy.surface.positions_mm.size(); ++v) {
    const Vec3& p = anatomy.surface.positions_mm[v];
    const int u = test_support::nearest_vertex(
        anatomy, -p.x(), p.y(), [&](int w) { return anatomy.region[w] == anatomy.region[v]; });
    for (std::size_t k = 0; k < lattice.columns[v].nodes.size(); ++k) {
      twin[lattice.columns[v].nodes[k]] = lattice.columns[u].nodes[k];
    }
  }
  return twin;
}

TEST_P(EveryEffect, MirroredFaceHasMirroredForces) {
  Scene scene(usual());
  const std::vector<int> twin = twins(scene);
  const auto mirrored = [&](const std::vector<Vec3>& x) {
    std::vector<Vec3> result(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      result[twin[k]] = Vec3(-x[k].x(), x[k].y(), x[k].z());
    }
    return result;
  };
  const std::vector<Vec3> place = scene.random_positions(15, 2.0);
  const std::vector<Vec3> x = scene.random_positions(16, 3.0);
  Eigen::VectorXd g, gm;
  scene.wake(place);
  const double value = scene.energy.evaluate(x, g);
  scene.wake(mirrored(place));
  EXPECT_NEAR(scene.energy.evaluate(mirrored(x), gm), value, 1e-10 * std::abs(value));
  double largest = 0.0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Vec3 f = g.segment<3>(3 * k);
    largest = std::max(largest, (gm.segment<3>(3 * twin[k]) - Vec3(-f.x(), f.y(), f.z())).norm());
  }
  EXPECT_LE(largest, 1e-9 * g.lpNorm<Eigen::Infinity>());
}

TEST_P(EveryEffect, RemembersNothingButWhatTheStateHolds) {
  Scene one(usual());
  FaceState state = one.at_rest();
  for (const unsigned seed : {17U, 18U}) {
    one.energy.begin_step(state, kStepS);
    state.positions_mm = one.random_positions(seed, 2.0);
    one.energy.end_step(state);
  }
  Scene fresh(usual());
  FaceState copy = state;
  const std::vector<Vec3> x = one.random_positions(19, 2.0);
  Eigen::VectorXd g, gf;
  one.energy.begin_step(state, 0.5 * kStepS);
  fresh.energy.begin_step(copy, 0.5 * kStepS);
  EXPECT_EQ(one.energy.evaluate(x, g), fresh.energy.evaluate(x, gf));
  EXPECT_EQ(g, gf);
  for (Scene* scene : {&one, &fresh}) {
    FaceState& its = scene == &one ? state : copy;
    its.positions_mm = x;
    scene->energy.end_step(its);
  }
  EXPECT_EQ(state.velocities_mm_per_s, copy.velocities_mm_per_s);
  EXPECT_EQ(state.history, copy.history);
}

TEST_P(EveryEffect, MemoryHasNoSayBetweenSteps) {
  Scene scene(usual());
  const std::vector<Vec3> x = scene.random_positions(20, 2.0);
  Eigen::VectorXd fresh, after;
  const double value = scene.gradient(x, fresh);
  FaceState state = scene.at_rest();
  scene.energy.begin_step(state, kStepS);
  state.positions_mm = scene.random_positions(21, 2.0);
  scene.energy.end_step(state);
  EXPECT_EQ(scene.gradient(x, after), value);
  EXPECT_EQ(after, fresh);
}

TEST_P(EveryEffect, RestrictedToSomeNodesItActsOnTheseAsBefore) {
  Scene scene(usual());
  scene.wake(scene.random_positions(22, 2.0));
  const std::vector<Vec3> x = scene.random_positions(23, 3.0);
  Eigen::VectorXd full, part, again;
  scene.energy.evaluate(x, full);
  std::vector<char> moving(x.size(), 0);
  for (int k = 0; k < scene.lattice().num_free_nodes; ++k) {
    moving[k] = scene.lattice().rest_mm[k].y() < -20.0;
  }
  scene.energy.restrict_to(moving);
  scene.energy.evaluate(x, part);
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!moving[k]) continue;
    const double scale = 1e-12 * full.lpNorm<Eigen::Infinity>();
    ASSERT_LE((part - full).segment<3>(3 * k).norm(), scale);
  }
  scene.energy.restrict_to(std::vector<char>(x.size(), 1));
  scene.energy.evaluate(x, again);
  EXPECT_EQ(again, full);
}

TEST(Effects, WhatIsNotAskedForIsNotThere) {
  const Anatomy anatomy = small_patch();
  const std::vector<double> contraction(anatomy.muscles.size(), 0.3);
  TissueModel plain;
  plain.effects = {};
  Eigen::VectorXd before, after;
  std::vector<Vec3> x;
  double value = 0.0;
  {
    FaceEnergy energy(anatomy, plain);
    EXPECT_TRUE(energy.effects().energy().empty());
    EXPECT_TRUE(energy.effects().memory().empty());
    energy.set_controls(contraction, 0.1);
    x = energy.lattice().rest_mm;
    energy.place_bone(x);
    value = energy.evaluate(x, before);
  }
  // A scene with everything there is leaves nothing behind.
  TissueModel full;
  full.effects.clear();
  for (const Effect& effect : all_effects()) full.effects.push_back({effect.name, {}});
  FaceEnergy everything(anatomy, full);
  Eigen::VectorXd other;
  everything.set_controls(contraction, 0.1);
  everything.evaluate(x, other);
  EXPECT_NE(other, before);
  FaceEnergy energy(anatomy, plain);
  energy.set_controls(contraction, 0.1);
  EXPECT_EQ(energy.evaluate(x, after), value);
  EXPECT_EQ(after, before);
}

// Springs and muscles alone, and with effects that a scene has but that are away: not one
// instruction more, not one allocation.
TEST(Effects, WhatIsAwayExecutesNothing) {
  const Anatomy anatomy = small_patch();  // every instruction is stepped through
  TissueModel plain;
  plain.effects = {};
  TissueModel full;
  full.effects.clear();
  for (const Effect& effect : all_effects()) {
    if (!effect.called_for_when.empty()) full.effects.push_back({effect.name, {}});
  }
  ASSERT_GE(full.effects.size(), 4U);
  const FaceEnergy bare(anatomy, plain);
  FaceEnergy energy(anatomy, full);
  for (std::size_t k = 0; k < full.effects.size(); ++k) energy.set_acts(k, false);
  std::vector<Vec3> x = bare.lattice().rest_mm;
  Random random(3);
  for (Vec3& p : x) p += random.vector();
  Eigen::VectorXd expected;
  Eigen::VectorXd gradient;
  const double value = bare.evaluate(x, expected);
  EXPECT_EQ(energy.evaluate(x, gradient), value);
  EXPECT_EQ(gradient, expected);
  if (test_support::can_count_allocations) {
    const long before = test_support::num_allocations;
    energy.evaluate(x, gradient);
    EXPECT_EQ(test_support::num_allocations, before);
  }
  const auto of = [&](const FaceEnergy& e) {
    return test_support::count_instructions([&] { e.evaluate(x, gradient); });
  };
  const std::optional<long> few = of(bare);
  const std::optional<long> same = of(energy);
  if (!few || !same) GTEST_SKIP() << "processes may not be traced here: instructions not counted";
  EXPECT_GT(*few, 10000);
  // Where memory happens to lie decides on a few.
  EXPECT_NEAR(
      static_cast<double>(*same), static_cast<double>(*few), 1e-3 * static_cast<double>(*few));
}

// And its second derivatives are those of what is there.
TEST(Effects, WhatIsAwayLeavesTheHessianAlone) {
  const Anatomy anatomy = small_patch();
  TissueModel full;
  full.effects.clear();
  for (const Effect& effect : all_effects()) full.effects.push_back({effect.name, {}});
  FaceEnergy energy(anatomy, full);
  TissueHessian h = energy.make_hessian();
  std::size_t away = 0;
  while (energy.effects().parts()[away].effect->name != "skull_contact") ++away;
  energy.set_acts(away, false);
  Random random(4);
  std::vector<Vec3> x = energy.lattice().rest_mm;
  for (Vec3& p : x) p += 3.0 * random.vector();
  energy.hessian(x, h);
  const Eigen::Index n = energy.num_unknowns();
  // The diagonal blocks tell pieces that ended up in the wrong place.
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  for (int axis = 0; axis < 3; ++axis) {
    for (int node = 0; node < energy.lattice().num_free_nodes; ++node) {
      std::vector<Vec3> unit(x.size(), Vec3::Zero());
      unit[node][axis] = 1.0;
      if (node % 7 != 0) continue;  // some will do
      HessianProduct product(unit);
      energy.add_hessian(x, product);
      diagonal[3 * node + axis] = product.result[3 * node + axis];
    }
  }
  double scale = diagonal.cwiseAbs().maxCoeff();
  ASSERT_GT(scale, 0.0);
  for (std::size_t c = 0; c < energy.lattice().columns.size(); ++c) {
    const Eigen::VectorXd block = h.free().diagonal(static_cast<int>(c)).diagonal();
    const std::vector<int>& nodes = energy.lattice().columns[c].nodes;
    for (Eigen::Index k = 0; k < block.size(); ++k) {
      const int node = nodes[k / 3];
      if (node % 7 != 0) continue;
      EXPECT_NEAR(block[k], diagonal[3 * node + k % 3], 1e-9 * scale);
    }
  }
}

TEST(Effects, EachAddsItsOwnTermsOnly) {
  const Anatomy anatomy = small_patch();
  std::size_t sum_energy = 0;
  std::size_t sum_memory = 0;
  TissueModel full;
  full.effects.clear();
  for (const Effect& effect : all_effects()) {
    TissueModel one;
    one.effects = {{effect.name, {}}};
    const FaceEnergy energy(anatomy, one);
    sum_energy += energy.effects().energy().size();
    sum_memory += energy.effects().memory().size();
    full.effects.push_back({effect.name, {}});
  }
  const FaceEnergy energy(anatomy, full);
  EXPECT_EQ(energy.effects().energy().size(), sum_energy);
  EXPECT_EQ(energy.effects().memory().size(), sum_memory);
}

TEST(Effects, OrderOfTheListHasNoSay) {
  const Anatomy anatomy = small_patch();
  TissueModel model;
  model.effects.clear();
  for (const Effect& effect : all_effects()) model.effects.push_back({effect.name, {}});
  TissueModel turned = model;
  std::reverse(turned.effects.begin(), turned.effects.end());
  const FaceEnergy one(anatomy, model);
  const FaceEnergy other(anatomy, turned);
  std::vector<Vec3> x = one.lattice().rest_mm;
  Random random(30);
  for (Vec3& p : x) p += random.vector();
  Eigen::VectorXd g, gt;
  EXPECT_EQ(one.evaluate(x, g), other.evaluate(x, gt));
  EXPECT_EQ(g, gt);
}

TEST(Anisotropy, SkinIsStifferInTheDirectionOfThePullByTheRatio) {
  Anatomy anatomy = make_face_patch();
  const int frontalis = anatomy.muscle_index("occipitofrontalis_inner_L");
  ASSERT_GE(frontalis, 0);
  anatomy.muscles = {anatomy.muscles[frontalis]};
  const Muscle& muscle = anatomy.muscles[0];
  const double ratio = 3.0;
  const Lattice plain = make_lattice(anatomy);
  Lattice lattice = plain;
  make_effects({{"anisotropy", {{"ratio", ratio}}}}, anatomy, lattice);
  double along = 0.0;  // the pull, which is across the lines
  double across = 0.0;
  int num_along = 0;
  int num_across = 0;
  for (std::size_t k = 0; k < plain.springs.size(); ++k) {
    const Spring& spring = plain.springs[k];
    const double factor = lattice.springs[k].law.alpha / spring.law.alpha;
    EXPECT_NEAR(lattice.springs[k].law.stiffening, factor * spring.law.stiffening, 1e-12);
    EXPECT_EQ(lattice.springs[k].rest_mm, spring.rest_mm);
    const bool below = std::min(spring.i, spring.j) >= plain.num_vertices;
    EXPECT_TRUE(!below || factor == 1.0);
    if (std::max(spring.i, spring.j) >= plain.num_vertices) continue;
    if ((plain.rest_mm[spring.i] - muscle.attachment_mm).norm() > 15.0) continue;
    const Vec3 r = (plain.rest_mm[spring.j] - plain.rest_mm[spring.i]).normalized();
    const double cosine =
        std::abs(r.dot((muscle.emergence_mm - muscle.attachment_mm).normalized()));
    if (cosine > 0.97) along += factor, ++num_along;
    if (cosine < 0.24) across += factor, ++num_across;
  }
  ASSERT_GT(num_along, 3);
  ASSERT_GT(num_across, 3);
  along /= num_along;
  across /= num_across;
  EXPECT_NEAR(along / across, ratio, 0.15 * ratio);
  EXPECT_NEAR(0.5 * (along + across), 1.0, 0.03) << "on average skin keeps its stiffness";
  Lattice same = plain;
  make_effects({{"anisotropy", {{"ratio", 1.0}}}}, anatomy, same);
  for (std::size_t k = 0; k < plain.springs.size(); ++k) {
    EXPECT_EQ(same.springs[k].law.alpha, plain.springs[k].law.alpha);
  }
}

INSTANTIATE_TEST_SUITE_P(Effects,
                         EveryEffect,
                         testing::ValuesIn(all_effects()),
                         [](const testing::TestParamInfo<Effect>& test) {
                           return test.param.name;
                         });

}  // namespace
}  // namespace zygoma
