// The interpreter of action units: HC-34.
#include "face/facs.h"

#include <gtest/gtest.h>

#include "src/base/check.h"
#include "tests/hard/record.h"

namespace zygoma::hard {
namespace {

using HC34 = testing::Test;

using Muscles = std::map<std::string, double>;

double contraction(const Pose& pose, const std::string& muscle) {
  const auto at = pose.contraction.find(muscle);
  return at == pose.contraction.end() ? 0.0 : at->second;
}

void expect_same(const Pose& a, const Pose& b, const std::string& what) {
  EXPECT_EQ(a.contraction, b.contraction) << what;
  EXPECT_EQ(a.jaw, b.jaw) << what;
}

TEST_F(HC34, SidesAndIntensitiesAreKept) {
  const Pose surprise = pose_of("1+2+5B+26");
  for (const char* side : {"_L", "_R"}) {
    EXPECT_EQ(contraction(surprise, std::string("occipitofrontalis_inner") + side), 1.0);
    EXPECT_EQ(contraction(surprise, std::string("occipitofrontalis_major") + side), 0.5);
    EXPECT_EQ(contraction(surprise, std::string("occipitofrontalis_outer") + side), 1.0);
    EXPECT_EQ(contraction(surprise, std::string("levator_palpebrae_superioris") + side), 0.4);
  }
  EXPECT_EQ(surprise.contraction.size(), 8U);
  EXPECT_GT(surprise.jaw, 0.0);
  record("\"1+2+5B+26\"",
         "8 muscles, lids at 0.4, jaw at " + figure(surprise.jaw),
         "parsed as documented");

  const Pose contempt = pose_of("R12A+R14A");
  EXPECT_EQ(contempt.contraction, (Muscles{{"zygomaticus_major_R", 0.2}, {"buccinator_R", 0.2}}));
  EXPECT_EQ(contempt.jaw, 0.0);
  record("\"R12A+R14A\"", "two muscles of the right side at 0.2", "sides kept");

  double last = 0.0;
  for (const char letter : {'A', 'B', 'C', 'D', 'E'}) {
    const double now = contraction(pose_of(std::string("L12") + letter), "zygomaticus_major_L");
    EXPECT_NEAR(now, last + 0.2, 1e-12);
    last = now;
  }
  expect_same(pose_of("12"), pose_of("12E"), "no letter");
  expect_same(pose_of("12:60%"), pose_of(" 12C "), "percent");
  EXPECT_TRUE(pose_of("12:0%").contraction.count("zygomaticus_major_L"));
  expect_same(pose_of("R12B+L12D"), pose_of("L12D + R12B"), "order");
  record("letters A to E, percentages, blanks, order",
         "0.2 to 1; the order has no effect",
         "parsed as documented");
}

TEST_F(HC34, LipsAreToldApart) {
  const Pose both = pose_of("18");
  const Pose top = pose_of("T18");
  const Pose bottom = pose_of("B18");
  EXPECT_EQ(contraction(bottom, "orbicularis_oris_superior_L"), 0.0);
  EXPECT_EQ(contraction(top, "orbicularis_oris_inferior_L"), 0.0);
  Muscles sum = top.contraction;
  sum.insert(bottom.contraction.begin(), bottom.contraction.end());
  EXPECT_EQ(sum, both.contraction);
  expect_same(pose_of("T18+B18"), both, "two lips");
  EXPECT_EQ(pose_of("LT18").contraction.size(), top.contraction.size() / 2);
  record("T18, B18 and LT18",
         "the top, the bottom and the left half of the top alone",
         "parsed as documented");
}

TEST_F(HC34, MusclesThatUnitsShareTakeTheStrongestWish) {
  const Pose both = pose_of("4+9");
  for (const auto& [muscle, value] : both.contraction) {
    EXPECT_EQ(value,
              std::max(contraction(pose_of("4"), muscle), contraction(pose_of("9"), muscle)));
    EXPECT_LE(value, 1.0);
  }
  const std::size_t num_units = action_units().size();
  Pose all;
  std::string text;
  for (const ActionUnit& unit : action_units()) {
    const bool excluded = unit.number == 27 || unit.number >= 41;
    if (excluded) continue;
    if (!text.empty()) text += "+";
    text += std::to_string(unit.number);
  }
  all = pose_of(text);
  for (const auto& [muscle, value] : all.contraction) {
    EXPECT_GT(value, 0.0) << muscle;
    EXPECT_LE(value, 1.0) << muscle;
  }
  record("units that share muscles (4+9), and all that go together of " + std::to_string(num_units),
         "the strongest wish for each muscle, at most 1",
         "never above 100 %");
}

TEST_F(HC34, WhatCannotBeDoneIsNamed) {
  struct Refusal {
    const char* text;
    const char* words;
  };
  int refused = 0;
  for (const auto& [text, words] : std::initializer_list<Refusal>{
           {"99", "no action unit 99"},
           {"0", "no action unit 0"},
           {"1+3", "no action unit 3"},
           {"99999999999999", "no number"},
           {"61", "turns the eyes"},
           {"51", "moves the head"},
           {"19", "tongue"},
           {"34", "breath"},
           {"29", "jaw forward"},
           {"12F", "intensity 'F', expected A to E"},
           {"12a", "intensity 'a'"},
           {"12BB", "intensity 'BB'"},
           {"12:120%", "120, expected 0 to 100"},
           {"12:-5%", "-5, expected 0 to 100"},
           {"12:nan%", "nan, expected 0 to 100"},
           {"12:60", "expected A to E or a percentage"},
           {"-12", "no number"},
           {"+12", "one is empty"},
           {"1++2", "one is empty"},
           {"1+2+", "one is empty"},
           {"12+12", "twice"},
           {"12A+R12B", "twice"},
           {"18+T18", "twice"},
           {"26+27", "26 and 27 exclude each other"},
           {"5+43", "5 and 43 exclude each other"},
           {"L26", "no sides"},
           {"T12", "no top and bottom"},
           {"U12", "expected L or R"},
           {"46", "expected L or R"},
           {"LR12", "no number"},
           {"X12", "no number"},
           {"12 14", "intensity"},
       }) {
    try {
      pose_of_action_units(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(words), std::string::npos) << text << ": " << message;
      EXPECT_EQ(message.find('\n'), std::string::npos);
      ++refused;
    }
  }
  // Not at odds: another side, another lip.
  EXPECT_NO_THROW(pose_of("L5+R46"));
  EXPECT_NO_THROW(pose_of("25+26"));
  record(
      "unknown units, units without a muscle, bad intensities, duplicates, 26 with 27, more than "
      "100 %",
      std::to_string(refused) + " strings refused, each with the unit and the reason",
      "rejected as documented; nothing silently dropped",
      Outcome::kRefused);
}

}  // namespace
}  // namespace zygoma::hard
