// zygoma effects: the list of all, and why those of a scene acted when they did.
#include <gtest/gtest.h>

#include "face/effect.h"
#include "src/io/text.h"
#include "src/pipeline/explain_effects.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

// A smile that comes and stays long enough for the face to come to rest.
constexpr const char* kSmile = R"({
  "tissue": {"layers": "bi"},
  "effects": "auto",
  "motion": {"frames_per_s": 15, "keys": [
    {"time_s": 0}, {"time_s": 0.6}, {"time_s": 1.0, "pose": "12:60%"},
    {"time_s": 4.0, "pose": "12:60%"}]}
})";

const std::vector<std::string> kColumns{"effect",
                                        "in_scene",
                                        "frames_on",
                                        "ranges",
                                        "ms_with",
                                        "ms_without",
                                        "largest_mm",
                                        "rms_mm",
                                        "could_change_mm",
                                        "why"};

TEST(EffectsCommandTest, ListsEveryEffectWithItsParameters) {
  const ScratchFolder folder;
  const Outcome outcome = run_program(folder, {"effects"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const Effect& effect : all_effects()) {
    EXPECT_NE(outcome.out.find(effect.name + ": " + effect.what), std::string::npos);
    for (const EffectParameter& p : effect.parameters) {
      EXPECT_NE(outcome.out.find(p.name), std::string::npos) << p.name;
    }
  }
}

TEST(EffectsCommandTest, ExplainsAScene) {
  const ScratchFolder folder;
  const std::string scene = folder.write("smile.json", kSmile);
  const Outcome outcome =
      run_program(folder, {"effects", "--explain", scene, "-o", folder / "out"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("(tolerance 0.1 mm)"), std::string::npos) << outcome.out;
  const CsvTable table(folder / "out/effects.csv", "effects of a scene", kColumns);
  ASSERT_EQ(table.num_rows(), static_cast<int>(all_effects().size()));
  for (int row = 0; row < table.num_rows(); ++row) {
    const std::string name(table.cell(row, 0));
    EXPECT_EQ(name, all_effects()[row].name);
    EXPECT_NE(outcome.out.find(name), std::string::npos);
    EXPECT_EQ(table.cell(row, 1), name == "gravity" ? "0" : "1");
    const double frames = table.number(row, table.find("frames_on"), 0.0, 61.0);
    const double changes = table.number(row, table.find("largest_mm"), 0.0, 100.0);
    EXPECT_FALSE(table.cell(row, table.find("why")).empty());
    if (name == "viscosity") {
      EXPECT_GT(changes, 0.1);
      // Rests at first, then moves and creeps, then stands.
      EXPECT_GT(frames, 5.0);
      EXPECT_LT(frames, 40.0);
      EXPECT_NE(std::string(table.cell(row, table.find("ranges"))).find("0"), std::string::npos);
    }
    if (name == "teeth_contact") {
      EXPECT_LE(frames, 1.0);
    }
  }
}

TEST(EffectsCommandTest, StaysWithinTheToleranceAndSaysSo) {
  const ScratchFolder folder;
  const std::string scene = folder.write("smile.json", kSmile);
  const Outcome exact = run_program(
      folder, {"effects", "--explain", scene, "--effects", "auto", "--effects-tolerance", "0.02"});
  ASSERT_EQ(exact.code, 0) << exact.err;
  EXPECT_NE(exact.out.find("(tolerance 0.02 mm)"), std::string::npos) << exact.out;
  const auto at = exact.out.find("differs by ");
  ASSERT_NE(at, std::string::npos);
  EXPECT_LE(std::stod(exact.out.substr(at + 11)), 0.02);
}

TEST(EffectsCommandTest, RefusesWhatItCannotExplain) {
  const ScratchFolder folder;
  const Outcome alone = run_program(folder, {"effects", "-o", folder / "out"});
  EXPECT_EQ(alone.code, 2);
  EXPECT_NE(alone.err.find("--explain"), std::string::npos) << alone.err;
  const Outcome missing = run_program(folder, {"effects", "--explain", folder / "no.json"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.err.find("no.json"), std::string::npos) << missing.err;
}

TEST(EffectsCommandTest, FrameRangesAsText) {
  EXPECT_EQ(text_of({}), "");
  EXPECT_EQ(text_of({{3, 3}, {7, 12}}), "3 7-12");
}

}  // namespace
}  // namespace zygoma
