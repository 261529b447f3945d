// The tables behind action units and expressions.
#include "face/facs.h"

#include <gtest/gtest.h>

#include <set>

#include "face/muscle_table.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

TEST(Facs, EveryUnitPullsMusclesThatThereAre) {
  std::set<std::string> known;
  for (const std::string& name : standard_muscle_names()) {
    EXPECT_TRUE(known.insert(name).second) << name << " is there twice";
  }
  EXPECT_GE(known.size(), 30U);
  std::set<std::string> used;
  int last = 0;
  for (const ActionUnit& unit : action_units()) {
    EXPECT_GT(unit.number, last);
    last = unit.number;
    EXPECT_FALSE(unit.pulls.empty() && unit.jaw == 0.0) << unit.number;
    for (const ActionPull& pull : unit.pulls) {
      EXPECT_TRUE(known.count(std::string(pull.muscle) + "_L")) << pull.muscle;
      EXPECT_TRUE(known.count(std::string(pull.muscle) + "_R")) << pull.muscle;
      EXPECT_GT(pull.weight, 0.0);
      EXPECT_LE(pull.weight, 1.0);
      used.insert(pull.muscle);
    }
  }
  // And no muscle is out of reach of the units.
  EXPECT_EQ(2 * used.size(), known.size());
}

TEST(Facs, ExpressionsAreTheirUnits) {
  for (const Expression& expression : expressions()) {
    SCOPED_TRACE(expression.name);
    const Pose pose = pose_of(expression.name);
    if (!expression.units.empty()) {
      EXPECT_EQ(pose.contraction, pose_of_action_units(expression.units).contraction);
      EXPECT_EQ(pose.jaw, pose_of_action_units(expression.units).jaw);
    }
    EXPECT_EQ(expression.name == "neutral", pose.contraction.empty());
    for (const auto& [muscle, value] : pose.contraction) {
      EXPECT_GT(value, 0.0) << muscle;
      EXPECT_LE(value, 1.0) << muscle;
    }
  }
  EXPECT_EQ(expressions().size(), 14U);
}

// His happiness: the left zygomaticus at 1.00 of his file, which is a factor 0.109 of equation (3),
// out of our 0.30.
TEST(Facs, MacrosOfWatersAreInSharesOfOurRange) {
  const Pose happiness = pose_of("waters:happiness");
  EXPECT_NEAR(happiness.contraction.at("zygomaticus_major_L"), 0.109 / 0.30, 1e-12);
  EXPECT_NEAR(happiness.contraction.at("zygomaticus_major_R"), 1.1 * 0.109 / 0.30, 1e-12);
  EXPECT_EQ(happiness.contraction.count("depressor_anguli_oris_L"), 0U);
  EXPECT_EQ(happiness.jaw, 0.0);
}

TEST(Facs, MusclesByName) {
  const Pose pose = pose_of("zygomaticus_major=0.5, mentalis_L=1 ,jaw=0.25");
  EXPECT_EQ(pose.contraction,
            (std::map<std::string, double>{
                {"zygomaticus_major_L", 0.5}, {"zygomaticus_major_R", 0.5}, {"mentalis_L", 1.0}}));
  EXPECT_EQ(pose.jaw, 0.25);
  for (const char* text : {"mentalis=2",
                           "mentalis=nan",
                           "mentalis=",
                           "mentalis=x",
                           "=1",
                           "mental=1",
                           "mentalis_L=1,mentalis=1",
                           "jaw=0.1,jaw=0.2",
                           "mentalis=1,",
                           "mentalis=1,jaw",
                           "happines",
                           "",
                           "  "}) {
    EXPECT_THROW(pose_of(text), InputError) << text;
  }
}

TEST(Facs, AFaceWithoutTheMuscleSaysSo) {
  Anatomy anatomy;
  anatomy.muscles.resize(1);
  anatomy.muscles[0].name = "mentalis_L";
  const Controls controls = controls_of(pose_of("mentalis_L=0.5,jaw=0.5"), anatomy);
  EXPECT_EQ(controls.contraction, std::vector<double>{0.5});
  EXPECT_EQ(controls.jaw_rad, 0.5 * anatomy.jaw.full_rad);
  EXPECT_THROW(controls_of(pose_of("mentalis=0.5"), anatomy), InputError);
}

}  // namespace
}  // namespace zygoma
