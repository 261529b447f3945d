// zygoma simulate: the sample scenes run, effects go on and off, and what did not work is said.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "face/effect.h"
#include "src/io/contractions_file.h"
#include "src/io/scene_file.h"
#include "src/io/text.h"
#include "src/pipeline/simulate_scene.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

const std::vector<std::string> kColumns{"frame",
                                        "timestamp",
                                        "converged",
                                        "iterations",
                                        "factorisations",
                                        "residual",
                                        "inverted_elements",
                                        "mean_volume_change",
                                        "moving_share",
                                        "solved",
                                        "substeps",
                                        "restores",
                                        "largest_mm",
                                        "rms_mm",
                                        "ms"};

CsvTable motion_of(const std::string& folder) {
  return CsvTable(folder + "/motion.csv", "a motion", kColumns);
}

double column_max(const CsvTable& table, const std::string& name) {
  double largest = 0.0;
  for (int row = 0; row < table.num_rows(); ++row) {
    largest = std::max(largest, table.number(row, table.find(name), 0.0, 1e9));
  }
  return largest;
}

constexpr const char* kShortSmile = R"({
  "solver": {"relative_residual": 1e-5},
  "motion": {"frames_per_s": 10, "keys": [
    {"time_s": 0}, {"time_s": 0.4, "contractions": {"zygomaticus_major": 0.6}}]}
})";

TEST(SimulateTest, EverySampleSceneRuns) {
  const ScratchFolder folder;
  int num_scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ZYGOMA_SOURCE_DIR "/samples")) {
    if (entry.path().extension() != ".json") continue;
    SCOPED_TRACE(entry.path().string());
    ++num_scenes;
    const bool is_long = read_scene(entry.path().string()).motion.keys.back().time_s > 60.0;
    if (is_long && std::getenv("ZYGOMA_LONG_TESTS") == nullptr) continue;
    const std::string out = folder / entry.path().stem().string();
    const Outcome outcome = run_program(folder, {"simulate", entry.path().string(), "-o", out});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const CsvTable motion = motion_of(out);
    EXPECT_EQ(column_max(motion, "inverted_elements"), 0.0);
    EXPECT_GT(column_max(motion, "largest_mm"), 5.0);
    EXPECT_LT(column_max(motion, "residual"), 1e-4 + 1e-10);
    for (int row = 0; row < motion.num_rows(); ++row) {
      EXPECT_EQ(motion.cell(row, motion.find("converged")), "1") << "frame " << row;
    }
    const ContractionTrack track = read_contractions_csv(out + "/contractions.csv");
    EXPECT_EQ(static_cast<int>(track.frames.size()), motion.num_rows());
    const auto session = nlohmann::json::parse(bytes_of(out + "/session.json"));
    EXPECT_EQ(session["command"], "simulate");
    EXPECT_EQ(session["source"]["frames"], motion.num_rows());
    EXPECT_EQ(session["stages"][0]["frames_not_converged"], 0);
  }
  EXPECT_GE(num_scenes, 3);
}

TEST(SimulateTest, ComparesEveryEffect) {
  const ScratchFolder folder;
  const std::string scene = folder.write("smile.json", kShortSmile);
  const Outcome outcome =
      run_program(folder, {"simulate", scene, "-o", folder / "out", "--compare"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const CsvTable table(folder / "out/effects.csv",
                       "effects",
                       {"effect", "in_scene", "ms_with", "ms_without", "largest_mm", "rms_mm"});
  ASSERT_EQ(table.num_rows(), static_cast<int>(all_effects().size()));
  for (int row = 0; row < table.num_rows(); ++row) {
    const std::string name(table.cell(row, 0));
    EXPECT_EQ(name, all_effects()[row].name);
    EXPECT_NE(outcome.out.find(name), std::string::npos);
    EXPECT_EQ(table.cell(row, 1), name == "volume" ? "1" : "0");
    EXPECT_GT(table.number(row, table.required()[2], 0.0, 1e9), 0.0);
    const double largest = table.number(row, table.required()[4], 0.0, 1e9);
    const double rms = table.number(row, table.required()[5], 0.0, 1e9);
    EXPECT_LE(rms, largest);
    if (name == "volume" || name == "viscosity") {
      EXPECT_GT(largest, 0.1) << name << " changes nothing";
    }
  }
}

TEST(SimulateTest, EffectsGoOnAndOff) {
  const ScratchFolder folder;
  const std::string scene = folder.write("smile.json", kShortSmile);
  const auto motion_with = [&](std::vector<std::string> options) {
    std::vector<std::string> arguments{"simulate", scene, "-o", folder / "out"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = run_program(folder, arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const CsvTable motion = motion_of(folder / "out");
    std::string text;  // all but the time it took
    for (int row = 0; row < motion.num_rows(); ++row) {
      for (int c = 0; c + 1 < motion.num_columns(); ++c) {
        text += std::string(motion.cell(row, c)) + ",";
      }
    }
    return text;
  };
  const std::string plain = motion_with({});
  EXPECT_EQ(motion_with({}), plain) << "the same scene is the same motion";
  EXPECT_EQ(motion_with({"--with", "volume"}), plain) << "it is there already";
  EXPECT_NE(motion_with({"--with", "volume:factor=0.2"}), plain);
  EXPECT_NE(motion_with({"--with", "viscosity", "--with", "inertia:mass_factor=2"}), plain);
  EXPECT_EQ(motion_with({"--without", "volume", "--with", "volume"}), plain);
}

TEST(SimulateTest, SaysWhatDidNotConverge) {
  const ScratchFolder folder;
  const std::string scene = folder.write("hard.json", R"({
    "solver": {"relative_residual": 1e-14, "max_iterations": 1},
    "motion": {"frames_per_s": 10, "keys": [
      {"time_s": 0}, {"time_s": 0.2, "contractions": {"zygomaticus_major": 1}}]}})");
  const Outcome outcome = run_program(folder, {"simulate", scene, "-o", folder / "out"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 not converged"), std::string::npos) << outcome.out;
  const CsvTable motion = motion_of(folder / "out");
  EXPECT_EQ(motion.cell(0, motion.find("converged")), "1");  // at rest
  EXPECT_EQ(motion.cell(2, motion.find("converged")), "0");
}

TEST(SimulateTest, StillTissueIsLeftOutUnlessAllIsWanted) {
  const ScratchFolder folder;
  const std::string scene = folder.write("still.json", R"({
    "solver": {"still_mm": 0.1},
    "motion": {"frames_per_s": 10, "keys": [
      {"time_s": 0}, {"time_s": 0.2, "contractions": {"corrugator_supercilii": 0.5}}]}})");
  const std::string out = folder / "out";
  ASSERT_EQ(run_program(folder, {"simulate", scene, "-o", out}).code, 0);
  EXPECT_LT(column_max(motion_of(out), "moving_share"), 0.9);
  ASSERT_EQ(run_program(folder, {"simulate", scene, "-o", out, "--simulate-all"}).code, 0);
  EXPECT_EQ(column_max(motion_of(out), "moving_share"), 1.0);
}

TEST(SimulateTest, EffectsByNeedUnlessAllIsWanted) {
  const ScratchFolder folder;
  const std::string scene = folder.write("pause.json", R"({
    "effects": "auto",
    "motion": {"frames_per_s": 10, "keys": [{"time_s": 0}, {"time_s": 0.5}, {"time_s": 0.8, "pose": "12:30%"}]}})");
  const std::string out = folder / "out";
  const auto frames_solved = [&] {
    const CsvTable motion = motion_of(out);
    int num = 0;
    for (int row = 0; row < motion.num_rows(); ++row) {
      num += motion.cell(row, motion.find("solved")) == "1";
    }
    return num;
  };
  ASSERT_EQ(run_program(folder, {"simulate", scene, "-o", out}).code, 0);
  EXPECT_LE(frames_solved(), 5);
  ASSERT_EQ(run_program(folder, {"simulate", scene, "-o", out, "--simulate-all"}).code, 0);
  EXPECT_EQ(frames_solved(), 9);
}

TEST(SimulateTest, TimePassesForEffectsWithMemory) {
  const ScratchFolder folder;
  Scene scene = read_scene(folder.write("smile.json", kShortSmile));
  scene.motion.duration_s = 0.8;
  scene.tissue.effects.push_back({"viscosity", {{"ratio", 4.0}, {"relaxation_s", 0.2}}});
  const auto anatomy =
      std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
  const Simulation simulation =
      simulate_scene(scene, anatomy, sample_motion(scene.motion, anatomy->muscle_names()), {}, {});
  ASSERT_EQ(simulation.rows.size(), 9U);
  // The pose is held from frame 4 on; the tissue still creeps towards it.
  EXPECT_GT(simulation.rows[6].rms_mm, simulation.rows[4].rms_mm + 1e-3);
  EXPECT_GT(simulation.rows[8].rms_mm, simulation.rows[6].rms_mm);
}

TEST(SimulateTest, WhereTimePassesAllTissueMoves) {
  const ScratchFolder folder;
  const std::string scene = folder.write("swing.json", R"({
    "solver": {"still_mm": 0.1}, "effects": {"volume": {}, "inertia": {}},
    "motion": {"frames_per_s": 30, "keys": [
      {"time_s": 0}, {"time_s": 0.2, "contractions": {"corrugator_supercilii": 0.8}}]}})");
  const std::string out = folder / "out";
  ASSERT_EQ(run_program(folder, {"simulate", scene, "-o", out}).code, 0);
  const CsvTable motion = motion_of(out);
  for (int row = 1; row < motion.num_rows(); ++row) {
    EXPECT_EQ(motion.number(row, motion.find("moving_share"), 0.0, 1.0), 1.0) << row;
  }
  EXPECT_GT(column_max(motion, "iterations"), 2.0);
  EXPECT_GT(column_max(motion, "largest_mm"), 2.0);
}

TEST(SimulateTest, TakesExplicitStepsWhereTheSceneAsksForThem) {
  const ScratchFolder folder;
  const std::string scene = folder.write("paper.json", R"({
    "solver": {"kind": "explicit"}, "effects": {"volume": {}, "inertia": {"damping_per_s": 200}},
    "motion": {"frames_per_s": 30, "keys": [
      {"time_s": 0}, {"time_s": 0.1, "contractions": {"zygomaticus_major": 0.5}}]}})");
  const std::string out = folder / "out";
  const Outcome outcome = run_program(folder, {"simulate", scene, "-o", out});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const CsvTable motion = motion_of(out);
  for (int row = 1; row < motion.num_rows(); ++row) {
    EXPECT_GT(motion.integer(row, motion.find("substeps"), 0, 1000000), 10) << row;
    EXPECT_EQ(motion.cell(row, motion.find("converged")), "1");
  }
  EXPECT_GT(column_max(motion, "largest_mm"), 0.5);
}

TEST(SimulateTest, WritesVideoAndPicture) {
  const ScratchFolder folder;
  const std::string scene = folder.write("smile.json", kShortSmile);
  const Outcome outcome = run_program(folder,
                                      {"simulate",
                                       scene,
                                       "-o",
                                       folder / "out",
                                       "--video",
                                       folder / "smile.mp4",
                                       "--picture",
                                       folder / "smile.png",
                                       "--height",
                                       "120"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(bytes_of(folder / "smile.png").starts_with("\x89PNG"));
  EXPECT_GT(bytes_of(folder / "smile.mp4").size(), 1000U);
}

TEST(SimulateTest, RefusesWhatItCannotUse) {
  const ScratchFolder folder;
  const std::string good = folder.write("good.json", kShortSmile);
  const std::string bad = folder.write("bad.json", R"({"effects": {"gravty": {}}})");
  const std::string paper = folder.write(
      "paper.json", R"({"solver": {"kind": "magic"}, "motion": {"keys": [{"time_s": 0}]}})");
  const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> cases{
      {{folder / "none.json"}, {"none.json: No such file", "expected a scene file"}},
      {{bad}, {bad, "'gravty' is unknown", "volume"}},
      {{paper}, {paper, "solver.kind", "equilibrium, explicit"}},
      {{good, "--with", "gravty"}, {"--with", "gravty", "volume"}},
      {{good, "--with", "volume:factor"}, {"--with: 'factor'", "parameter=value"}},
      {{good, "--with", "volume:factor=much"}, {"--with: 'factor=much'", "no number"}},
      {{good, "--with", "volume:factor=1,factor=2"}, {"--with", "twice"}},
      {{good, "--with", "volume:factor=-2"}, {"--with", "factor is -2", "0 to 100"}},
      {{good, "--with", "volume:colour=1"}, {"--with", "colour", "factor"}},
      {{good, "--without", "gravty"}, {"--without: 'gravty' is unknown", "volume"}},
      {{good, "--picture", folder / "smile.gif"}, {"smile.gif", ".png or .jpg"}},
      {{good, "--video", good}, {"good.json: is the input itself"}},
  };
  for (const auto& [given, words] : cases) {
    std::vector<std::string> arguments{"simulate", "-o", folder / "out"};
    arguments.insert(arguments.end(), given.begin(), given.end());
    const Outcome outcome = run_program(folder, arguments);
    SCOPED_TRACE(outcome.err);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(num_lines(outcome.err), 1);
    for (const std::string& word : words) EXPECT_NE(outcome.err.find(word), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << "left behind";
  }
}

TEST(SimulateTest, CtrlCKeepsTheFramesDone) {
  const ScratchFolder folder;
  const std::string scene = folder.write("long.json", R"({
    "motion": {"frames_per_s": 1000, "keys": [
      {"time_s": 0}, {"time_s": 30, "jaw": 1, "contractions": {"zygomaticus_major": 1}}]}})");
  const std::string video = folder / "long.mp4";
  RunningProgram program(folder, {"simulate", scene, "-o", folder / "out", "--video", video});
  ASSERT_TRUE(program.wait_for(video + ".part"));
  program.press_ctrl_c();
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  const int num_frames = motion_of(folder / "out").num_rows();
  EXPECT_GE(num_frames, 1);
  EXPECT_LT(num_frames, 30001);
  EXPECT_TRUE(std::filesystem::exists(video));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/session.json"));
}

}  // namespace
}  // namespace zygoma
