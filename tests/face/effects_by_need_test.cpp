// Effects that a scene leaves to the program: there where they are called for and nowhere else, and
// the face stays within the tolerance of everything in every frame, without a jump.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "face/facs.h"
#include "face/generic_head.h"
#include "face/motion.h"
#include "face/simulator.h"

namespace zygoma {
namespace {

constexpr double kToleranceMm = SettleOptions::kUsualChooseMm;
constexpr double kLargestJumpMm = 0.6 * kToleranceMm;  // of the difference, from frame to frame

const std::shared_ptr<const Anatomy>& head() {
  static const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 300, .skin_levels = 0, .albedo_size_px = 64}));
  return anatomy;
}

struct Pace {
  double time_s = 0.0;
  std::string pose;  // empty: rest
  double jaw = 0.0;  // [0, 1], if the pose does not say
};

std::vector<Controls> controls_of(const std::vector<Pace>& paces) {
  Motion motion;
  for (const Pace& pace : paces) {
    const Pose pose = pace.pose.empty() ? Pose{} : pose_of(pace.pose);
    motion.keys.push_back({pace.time_s, std::max(pose.jaw, pace.jaw), pose.contraction});
  }
  std::vector<Controls> controls;
  for (const Contractions& frame : sample_motion(motion, head()->muscle_names()).frames) {
    controls.push_back({frame.value, frame.jaw * head()->jaw.full_rad});
  }
  return controls;
}

struct Played {
  std::vector<std::vector<Vec3>> surfaces_mm;
  std::vector<SettleReport> reports;
  std::vector<std::map<std::string, EffectUse>> uses;

  // Frames in which an effect executed anything, the first (a jump from rest) aside.
  int frames_with(const std::string& effect) const {
    int num = 0;
    for (std::size_t k = 1; k < uses.size(); ++k) {
      num += reports[k].solved && uses[k].at(effect).acts;
    }
    return num;
  }
  int frames_solved() const {
    return static_cast<int>(std::count_if(
        reports.begin(), reports.end(), [](const SettleReport& r) { return r.solved; }));
  }
};

TissueModel tissue_with(const std::vector<EffectChoice>& effects) {
  TissueModel tissue;
  tissue.lattice.layers = bi_layer();
  tissue.effects = effects;
  return tissue;
}

Played play(const std::vector<EffectChoice>& effects,
            const std::vector<Controls>& controls,
            double choose_mm) {
  constexpr double kFrameS = 1.0 / 30.0;
  SettleOptions options;
  options.relative_residual = 1e-4;
  options.choose_mm = choose_mm;
  Simulator face(head(), tissue_with(effects), options);
  FaceState state = face.rest();
  Played played;
  for (std::size_t k = 0; k < controls.size(); ++k) {
    played.reports.push_back(k == 0 ? face.settle(controls[k], state)
                                    : face.advance(controls[k], kFrameS, state));
    played.surfaces_mm.emplace_back(
        state.positions_mm.begin(),
        state.positions_mm.begin() + static_cast<long>(head()->surface.positions_mm.size()));
    std::map<std::string, EffectUse> uses;
    const std::vector<EffectUse> known = face.effect_uses();
    for (std::size_t e = 0; e < known.size(); ++e) {
      uses[face.effects()[e].effect->name] = known[e];
    }
    played.uses.push_back(std::move(uses));
  }
  return played;
}

double largest_distance(const Played& a, const Played& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.surfaces_mm.size(); ++k) {
    for (std::size_t v = 0; v < a.surfaces_mm[k].size(); ++v) {
      largest = std::max(largest, (a.surfaces_mm[k][v] - b.surfaces_mm[k][v]).norm());
    }
  }
  return largest;
}

// Of the difference of two faces, what it changes by from one frame to the next.
double largest_jump(const Played& a, const Played& b) {
  double largest = 0.0;
  for (std::size_t k = 1; k < a.surfaces_mm.size(); ++k) {
    for (std::size_t v = 0; v < a.surfaces_mm[k].size(); ++v) {
      const Vec3 now = a.surfaces_mm[k][v] - b.surfaces_mm[k][v];
      const Vec3 before = a.surfaces_mm[k - 1][v] - b.surfaces_mm[k - 1][v];
      largest = std::max(largest, (now - before).norm());
    }
  }
  return largest;
}

std::vector<EffectChoice> usual_but(const EffectChoice& choice) {
  std::vector<EffectChoice> effects = usual_effects();
  for (EffectChoice& effect : effects) {
    if (effect.name == choice.name) effect = choice;
  }
  return effects;
}

std::vector<EffectChoice> without(const std::string& effect) {
  std::vector<EffectChoice> effects = usual_effects();
  std::erase_if(effects, [&](const EffectChoice& choice) { return choice.name == effect; });
  return effects;
}

// One effect, a motion that needs it and one that does not.
struct Case {
  EffectChoice effect;
  std::vector<Pace> needs;
  std::vector<Pace> does_not;
};

const std::vector<Case>& cases() {
  static const std::vector<Pace> kBrow{{0.0, ""}, {0.4, "1+2"}, {1.2, "1+2"}, {1.6, ""}, {2.4, ""}};
  // So slow that nothing lags.
  static const std::vector<Pace> kCreeping{{0.0, ""}, {4.0, "1:4%"}};
  static const std::vector<Case> all{
      {{"inertia", {}}, {{0.0, ""}, {0.1, "", 0.8}, {0.25, "", 0.1}, {1.2, "", 0.1}}, kCreeping},
      {{"viscosity", {}},
       {{0.0, ""}, {0.2, "6+12"}, {1.2, "6+12"}, {1.4, ""}, {3.0, ""}},
       kCreeping},
      {{"lip_contact", {}},
       {{0.0, ""}, {0.4, "24+17"}, {1.2, "24+17"}, {1.6, ""}, {2.4, ""}},
       {{0.0, ""}, {0.4, "25", 0.5}, {2.0, "25", 0.5}}},
      {{"teeth_contact", {}},
       {{0.0, ""}, {0.4, "28"}, {1.0, "28"}, {1.3, "", 0.6}, {1.8, ""}, {2.4, ""}},
       kBrow},
      // Of a skull so close below that it is reached.
      {{"skull_contact", {{"distance_share", 0.9}}},
       {{0.0, ""}, {0.3, "4+9"}, {1.2, "4+9"}, {1.5, ""}, {2.4, ""}},
       {{0.0, ""}, {0.6, "12:30%"}, {1.2, ""}}},
  };
  return all;
}

class EffectByNeed : public testing::TestWithParam<std::size_t> {
 protected:
  const Case& one() const { return cases()[GetParam()]; }
  static void expect_like_everything(const Played& chosen, const Played& everything) {
    EXPECT_LE(largest_distance(chosen, everything), kToleranceMm);
    EXPECT_LE(largest_jump(chosen, everything), kLargestJumpMm);
    for (const SettleReport& report : chosen.reports) EXPECT_TRUE(report.converged);
  }
};

TEST_P(EffectByNeed, IsThereWhereItIsCalledFor) {
  const std::vector<Controls> controls = controls_of(one().needs);
  const std::vector<EffectChoice> effects = usual_but(one().effect);
  const Played chosen = play(effects, controls, kToleranceMm);
  const Played everything = play(effects, controls, 0.0);
  expect_like_everything(chosen, everything);
  EXPECT_GT(chosen.frames_with(one().effect.name), 0);
  // The motion does need it: else this test could not fail.
  EXPECT_GT(largest_distance(play(without(one().effect.name), controls, 0.0), everything),
            kToleranceMm);
}

TEST_P(EffectByNeed, IsNotThereWhereItIsNot) {
  const std::vector<Controls> controls = controls_of(one().does_not);
  const Played chosen = play(usual_effects(), controls, kToleranceMm);
  expect_like_everything(chosen, play(usual_effects(), controls, 0.0));
  EXPECT_EQ(chosen.frames_with(one().effect.name), 0);
  EXPECT_GT(chosen.frames_solved(), 1) << "nothing moved at all";
}

INSTANTIATE_TEST_SUITE_P(All,
                         EffectByNeed,
                         testing::Range(std::size_t{0}, cases().size()),
                         [](const auto& one) { return cases()[one.param].effect.name; });

// Everything moves fast all the time: no effect, no tissue and no frame is left out, and so not a
// bit is different.
TEST(EffectsByNeed, SameBitsWhereNothingIsLeftOut) {
  const std::vector<EffectChoice> effects{{"volume", {}}, {"inertia", {}}, {"viscosity", {}}};
  std::vector<Pace> paces{{0.0, ""}};
  for (int k = 1; k <= 6; ++k) {
    paces.push_back({0.2 * k, k % 2 == 1 ? "1+2+6+12+20+15:50%" : "4+9:50%+10", k % 2 * 0.4});
  }
  const std::vector<Controls> controls = controls_of(paces);
  const Played chosen = play(effects, controls, kToleranceMm);
  ASSERT_EQ(chosen.frames_solved(), static_cast<int>(controls.size()));
  for (const EffectChoice& choice : effects) {
    ASSERT_EQ(chosen.frames_with(choice.name), static_cast<int>(controls.size()) - 1);
  }
  for (const SettleReport& report : chosen.reports) ASSERT_EQ(report.moving_share, 1.0);
  const Played everything = play(effects, controls, 0.0);
  EXPECT_TRUE(chosen.surfaces_mm == everything.surfaces_mm);
}

TEST(EffectsByNeed, SameBitsOnEveryRun) {
  const std::vector<Controls> controls = controls_of(cases()[3].needs);
  EXPECT_TRUE(play(usual_effects(), controls, kToleranceMm).surfaces_mm ==
              play(usual_effects(), controls, kToleranceMm).surfaces_mm);
}

TEST(EffectsByNeed, AFaceThatStandsStillIsNotSolved) {
  const std::vector<Controls> controls =
      controls_of({{0.0, ""}, {0.3, "6+12"}, {4.0, "6+12"}, {5.0, "6+12"}});
  const Played chosen = play(usual_effects(), controls, kToleranceMm);
  EXPECT_TRUE(chosen.reports[3].solved);
  // From 3.5 s after the smile has come.
  for (std::size_t k = 115; k < controls.size(); ++k) {
    EXPECT_FALSE(chosen.reports[k].solved) << "frame " << k;
    EXPECT_TRUE(chosen.surfaces_mm[k] == chosen.surfaces_mm[k - 1]) << "frame " << k;
  }
}

TEST(EffectsByNeed, TissueRestsWhereNothingPulls) {
  const std::vector<Controls> controls =
      controls_of({{0.0, ""}, {0.3, "L1"}, {0.6, ""}, {0.9, "L1"}, {1.2, ""}});
  const Played chosen = play(usual_effects(), controls, kToleranceMm);
  double smallest = 1.0;
  for (const SettleReport& report : chosen.reports) {
    smallest = std::min(smallest, report.moving_share);
  }
  EXPECT_LT(smallest, 0.5);
  EXPECT_LE(largest_distance(chosen, play(usual_effects(), controls, 0.0)), kToleranceMm);
}

// Inertia that comes back must find the speed that the tissue has by then, not that of the frame in
// which it went.
TEST(EffectsByNeed, SpeedIsKnownWhereInertiaIsAway) {
  const std::vector<Controls> controls = controls_of({{0.0, ""}, {0.3, "6+12"}, {2.0, "6+12"}});
  SettleOptions options;
  options.choose_mm = kToleranceMm;
  const EffectChoice light{"inertia", {{"mass_factor", 0.01}}};
  Simulator face(head(), tissue_with({light, {"viscosity", {}}}), options);
  FaceState state = face.rest();
  face.settle(controls[0], state);
  int num = 0;
  for (std::size_t k = 1; k < controls.size(); ++k) {
    const FaceState before = state;
    if (!face.advance(controls[k], 1.0 / 32.0, state).solved) break;
    bool inertia_acts = true;
    bool viscosity_acts = false;
    for (std::size_t e = 0; e < face.effects().size(); ++e) {
      const std::string& name = face.effects()[e].effect->name;
      if (name == "inertia") inertia_acts = face.effect_uses()[e].acts;
      if (name == "viscosity") viscosity_acts = face.effect_uses()[e].acts;
    }
    if (inertia_acts || !viscosity_acts) continue;
    ++num;
    for (std::size_t v = 0; v < state.positions_mm.size(); ++v) {
      const Vec3 moved = state.positions_mm[v] - before.positions_mm[v];
      EXPECT_LE((state.velocities_mm_per_s[v] - 32.0 * moved).norm(), 1e-9);
    }
  }
  EXPECT_GT(num, 2);
}

// A state that is not the last one is a jump: nothing of what was left out before may cling to it.
TEST(EffectsByNeed, AnotherStateStartsWithEverything) {
  const std::vector<Controls> smile = controls_of({{0.0, ""}, {0.3, "6+12"}});
  SettleOptions options;
  options.choose_mm = kToleranceMm;
  Simulator face(head(), tissue_with(usual_effects()), options);
  FaceState state = face.rest();
  for (const Controls& controls : smile) face.advance(controls, 1.0 / 30.0, state);
  FaceState other = face.rest();
  other.positions_mm[0].x() += 1e-3;
  const SettleReport report = face.advance(smile.front(), 1.0 / 30.0, other);
  EXPECT_TRUE(report.solved);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.moving_share, 1.0);
}

}  // namespace
}  // namespace zygoma
