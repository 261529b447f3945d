#include "src/pipeline/tradeoff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>

#include "src/base/check.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "src/pipeline/comparison.h"
#include "src/pipeline/machine_load.h"
#include "src/pipeline/pick_quality.h"
#include "src/pipeline/pick_run.h"
#include "src/pipeline/tradeoff_clip.h"
#include "src/pipeline/tradeoff_tissue.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/silent_observer.h"

namespace zygoma {
namespace {

Scene short_scene() {
  Scene scene;
  scene.motion.frames_per_s = 10.0;
  scene.motion.keys = {{0.0, 0.0, {}},
                       {0.5, 0.1, {{"zygomaticus_major_L", 0.7}, {"zygomaticus_major_R", 0.7}}}};
  return scene;
}

TissueChoice choice(int vertices, bool bi_layer, double residual, const std::string& without = "") {
  return {"", {"", vertices, bi_layer, residual, 0.0}, Solver::kImplicit, without};
}

TradeoffRow row(double frame_ms, double error, double failed = 0.0) {
  TradeoffRow made;
  made.choice = std::to_string(frame_ms);
  made.frame_ms = frame_ms;
  made.error = error;
  made.failed = failed;
  return made;
}

TEST(TradeoffTest, TheFrontIsWhatNothingBeatsInBoth) {
  TradeoffStage stage{"tissue", "mm", "error", "largest mm", "the truth"};
  stage.rows = {row(4.0, 0.2), row(1.0, 0.9), row(2.0, 0.95), row(3.0, 0.1, 0.5), row(3.5, 0.5)};
  find_front(stage);
  std::vector<double> front;
  for (const TradeoffRow& one : stage.rows) {
    if (one.on_front) front.push_back(one.frame_ms);
  }
  EXPECT_EQ(front, (std::vector<double>{1.0, 3.5, 4.0}));  // at 3 ms half of the frames failed
}

TEST(TradeoffTest, FinerTissueIsCloserAndTheReferenceIsItself) {
  SilentObserver silent;
  const TissueChoice reference = choice(1000, false, 1e-6);
  const TradeoffStage stage = measure_tissue(short_scene(),
                                             {choice(300, false, 1e-4),
                                              choice(500, false, 1e-4),
                                              choice(500, false, 1e-4, "volume"),
                                              reference},
                                             reference,
                                             silent,
                                             {});
  ASSERT_EQ(stage.rows.size(), 5U);
  double coarse = 0.0, finer = 0.0, bare = 0.0;
  for (const TradeoffRow& one : stage.rows) {
    EXPECT_EQ(one.failed, 0.0);
    EXPECT_GT(one.frame_ms, 0.0);
    EXPECT_GE(one.other_error, one.error);
    EXPECT_EQ(one.choice.starts_with("1000"), one.error == 0.0);
    if (one.choice.starts_with("300")) coarse = one.error;
    if (one.choice.starts_with("500")) {
      (one.choice.find("without volume") != std::string::npos ? bare : finer) = one.error;
    }
  }
  EXPECT_GT(finer, 0.01);
  EXPECT_LT(finer, coarse);
  EXPECT_GT(bare, finer);
  EXPECT_LT(coarse, 3.0);  // of a corner of the mouth that moves by 10
  const ScratchFolder folder;
  write_tradeoff_csv(folder / "tradeoff.csv", {stage});
  write_tradeoff_plot(folder / "tradeoff.svg", {stage});
  EXPECT_EQ(num_lines(bytes_of(folder / "tradeoff.csv")), 6);
  EXPECT_GT(std::filesystem::file_size(folder / "tradeoff.svg"), 1000U);
}

TEST(TradeoffTest, StopsWhenAsked) {
  SilentObserver silent;
  int asked = 0;
  const TradeoffStage stage = measure_tissue(short_scene(),
                                             {choice(300, true, 1e-2), choice(300, false, 1e-2)},
                                             choice(300, true, 1e-4),
                                             silent,
                                             [&] { return ++asked > 8; });
  EXPECT_TRUE(stage.stopped);
  EXPECT_LT(stage.rows.size(), 3U);
}

// A line that moves down by 1 px per frame; the estimate lies 2 px beside it and lags by a share.
std::vector<ContourSet> moving_line(double offset_px, double speed) {
  std::vector<ContourSet> sets;
  for (int k = 0; k < 11; ++k) {
    ContourSet set;
    set.frame_index = k;
    Contour contour;
    contour.name = "hairline";
    contour.confidence = 1.0;
    for (int i = 0; i < 13; ++i) contour.points_px.emplace_back(10.0 * i, offset_px + speed * k);
    set.contours.push_back(contour);
    sets.push_back(set);
  }
  return sets;
}

TEST(TradeoffTest, AConstantOffsetIsNoErrorOfMotion) {
  const std::vector<ContourSet> truth = moving_line(0.0, 1.0);
  const ContourError beside = compare_contours(moving_line(2.0, 1.0), truth).front();
  EXPECT_NEAR(beside.median_px, 2.0, 1e-12);
  EXPECT_NEAR(beside.motion_median_px, 0.0, 1e-12);
  const ContourError lags = compare_contours(moving_line(2.0, 0.8), truth).front();
  EXPECT_NEAR(lags.motion_median_px, 0.2 * 3.0, 1e-9);  // frames 0 to 10 about the middle one
  EXPECT_GT(lags.motion_p90_px, lags.motion_median_px);
}

std::string sample(const char* ending) {
  return std::string(ZYGOMA_SOURCE_DIR "/samples/performer") + ending;
}

TradeoffClip sample_clip(double duration_s) {
  TradeoffClip clip;
  clip.video = VideoSource(sample(".mp4"));
  clip.duration_s = duration_s;
  return clip;
}

TEST(TradeoffTest, TrackerIsHeldAgainstTheTruthOrTheMostCarefulSetting) {
  SilentObserver silent;
  const std::vector<TrackerChoice> all = tracker_choices();
  const auto is = [&](const char* name) {
    return *std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.name == name; });
  };
  const std::vector<TrackerChoice> few{all.front(), is("draft"), is("standard")};
  TradeoffClip clip = sample_clip(4.0);
  const TradeoffStage alone = measure_tracker(clip, few, tracker_reference(), silent, {});
  clip.true_contours = read_contours_csv(sample(".contours.csv"));
  const TradeoffStage known = measure_tracker(clip, few, tracker_reference(), silent, {});
  for (const TradeoffStage* stage : {&alone, &known}) {
    ASSERT_EQ(stage->rows.size(), 4U);
    double crude = 0.0, usual = 0.0;
    for (const TradeoffRow& one : stage->rows) {
      EXPECT_EQ(one.is_reference, one.error == 0.0);
      EXPECT_LT(one.failed, 0.01);
      if (one.family == "not predicted") crude = one.error;
      if (one.quality == "standard") usual = one.error;
    }
    EXPECT_GT(crude, usual);
  }
}

TEST(TradeoffTest, RefinementIsCloserThanTheClosedForm) {
  SilentObserver silent;
  TradeoffClip clip = sample_clip(2.0);
  clip.true_contractions = read_contractions_csv(sample(".contractions.csv"));
  Scene scene;
  face_quality("draft").apply(scene.head, scene.tissue, scene.settle);
  std::vector<RetargetChoice> few = retarget_choices();
  std::erase_if(few, [](const RetargetChoice& one) {
    return one.name.empty() && one.family != "closed form";
  });
  const RetargetChoice lattice = few.back();
  few.pop_back();
  const TradeoffStage stage = measure_retarget(clip, scene, few, lattice, silent, {});
  ASSERT_EQ(stage.rows.size(), 4U);
  double closed = 0.0, refined = 0.0;
  for (const TradeoffRow& one : stage.rows) {
    EXPECT_GT(one.other_error, 0.0);
    EXPECT_FALSE(one.is_reference);
    if (one.family == "closed form") {
      closed = one.error;
    } else {
      refined = std::max(refined, one.error);
    }
  }
  EXPECT_LT(refined, closed);
}

TEST(FaceQualityTest, IsKnownByName) {
  for (const FaceQuality& quality : face_qualities()) {
    EXPECT_EQ(face_quality(quality.name).surface_vertices, quality.surface_vertices);
  }
  EXPECT_THROW(face_quality("superb"), InputError);
}

TEST(PickQualityTest, TakesTheQuickestThatIsCloseEnough) {
  EXPECT_EQ(pick_for_tolerance(10.0).quality.name, "draft");
  const QualityPick fine = pick_for_tolerance(face_quality("fine").expected_rms_mm);
  EXPECT_EQ(fine.quality.name, "fine");
  EXPECT_EQ(pick_for_tolerance(1e-6).quality.name, "reference");
  double error = 1e9;
  for (const FaceQuality& quality : face_qualities()) {
    EXPECT_LT(quality.expected_rms_mm, error) << quality.name;
    error = quality.expected_rms_mm;
  }
}

TEST(RunQualityTest, SkinErrorsFallAndTimesRise) {
  const std::vector<RunQuality>& all = run_qualities();
  for (std::size_t k = 1; k < all.size(); ++k) {
    EXPECT_LE(all[k].face.expected_rms_mm, all[k - 1].face.expected_rms_mm) << all[k].name;
    EXPECT_GT(all[k].about_frame_ms, all[k - 1].about_frame_ms) << all[k].name;
  }
  EXPECT_THROW(run_quality("superb"), InputError);
  EXPECT_EQ(all[pick_for_run_tolerance(10.0)].name, "draft");
  EXPECT_EQ(all[pick_for_run_tolerance(1e-6)].name, "reference");
}

TEST(RunQualityTest, PromisesWhatWasMeasured) {
  std::ifstream file(std::string(ZYGOMA_SOURCE_DIR) + "/docs/results/run_quality.csv");
  std::map<std::string, std::vector<double>> measured;  // by quality, the columns after it
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string name;
    std::getline(cells, name, ',');
    for (std::string cell; std::getline(cells, cell, ',');) {
      measured[name].push_back(std::strtod(cell.c_str(), nullptr));
    }
  }
  constexpr std::size_t kStart_ms = 2;
  constexpr std::size_t kRest_ms = 3;
  constexpr std::size_t kContractions = 4;
  constexpr std::size_t kSkin_mm = 6;
  for (const RunQuality& quality : run_qualities()) {
    SCOPED_TRACE(quality.name);
    ASSERT_EQ(measured[quality.name].size(), 8U);
    const std::vector<double>& row = measured[quality.name];
    EXPECT_NEAR(quality.expected_contraction_rms, row[kContractions], 5.1e-4);
    EXPECT_NEAR(quality.face.expected_rms_mm, row[kSkin_mm], 5.1e-3);
    EXPECT_NEAR(quality.about_start_ms, row[kStart_ms], 0.1 * row[kStart_ms]);
    EXPECT_NEAR(quality.about_frame_ms, row[kRest_ms], 0.1 * row[kRest_ms]);
  }
}

TEST(BudgetTest, ForecastAndVerdictGoByOneMeasure) {
  EXPECT_EQ(budget_forecast(19.0, 20.0), "");
  EXPECT_EQ(budget_verdict(19.0, 20.0), "the budget is 20 ms: met");
  EXPECT_EQ(budget_forecast(20.05, 20.0), "");  // less than a percent is no difference
  EXPECT_EQ(budget_verdict(20.05, 20.0), "the budget is 20 ms: met");
  EXPECT_EQ(budget_forecast(21.4, 20.0), "the budget of 20 ms probably cannot be met, 7 % over");
  EXPECT_EQ(budget_verdict(21.4, 20.0), "the budget is 20 ms: not met, 7 % over");
  EXPECT_EQ(budget_verdict(2.0, 0.5), "the budget is 0.5 ms: not met, 4 times as long");
}

// A machine on which everything takes `slower` times as long as in the table, and its clock.
struct Machine {
  double slower = 1.0;
  double now_ms = 0.0;
  int trials = 0;

  RunPick pick(double budget_ms, std::size_t num_frames = 600) {
    const auto cost_of = [&](std::size_t k) {
      const RunQuality& quality = run_qualities()[k];
      const RunCost cost{100.0 * slower, slower * quality.about_frame_ms};
      now_ms += slower * quality.about_start_ms + 24.0 * cost.frame_ms;
      ++trials;
      return cost;
    };
    now_ms = 5.0 * slower * static_cast<double>(num_frames);  // tracked
    const std::size_t guess = guess_quality(budget_ms, num_frames, slower, now_ms);
    return pick_by_trials(budget_ms, guess, num_frames, cost_of, [&] { return now_ms; });
  }
};

TEST(PickRunTest, TakesTheMostAccurateThatFits) {
  for (const double slower : {0.3, 1.0, 4.0}) {
    std::size_t last = 0;
    for (const double budget_ms : {10.0, 30.0, 60.0, 100.0, 250.0, 1000.0, 1e4}) {
      Machine machine{slower};
      const RunPick pick = machine.pick(budget_ms);
      SCOPED_TRACE(std::to_string(slower) + " " + std::to_string(budget_ms));
      EXPECT_GE(pick.quality, last);  // more time, not less accuracy
      last = pick.quality;
      EXPECT_LE(machine.trials, 4);
      EXPECT_TRUE(pick.quality == 0 || pick.expected_ms <= 1.06 * budget_ms);
    }
    EXPECT_EQ(last, run_qualities().size() - 1);
  }
}

TEST(PickRunTest, SaysWhatTheQuickestTakesWhereNothingFits) {
  Machine machine{3.0};
  const RunPick pick = machine.pick(2.0);
  EXPECT_EQ(pick.quality, 0U);
  EXPECT_GT(pick.expected_ms, 3.0 * run_qualities().front().about_frame_ms);
}

// The first frames of the sample clip.
std::string short_clip(const ScratchFolder& folder, int num_frames) {
  VideoReader reader(VideoSource(sample(".mp4")));
  const std::string path = folder / "clip.mp4";
  VideoWriter writer(path, reader.info().width_px, reader.info().height_px, 30.0);
  Frame frame;
  for (int k = 0; k < num_frames && reader.read(frame); ++k) {
    writer.write(frame.image, frame.time_s);
  }
  writer.finish();
  return path;
}

TEST(PickRunTest, TheProgramSaysWhatItPickedAndHowItWent) {
  const ScratchFolder folder;
  const std::string clip = short_clip(folder, 30);
  const auto run_with = [&](const char* option, const char* value) {
    return run_program(folder, {"run", clip, "-o", folder / "result", option, value});
  };
  const Outcome tight = run_with("--budget", "0.5");
  EXPECT_EQ(tight.code, 0) << tight.err;
  for (const char* words : {"quality draft", "cannot be met", "expected were", "not met"}) {
    EXPECT_NE(tight.err.find(words), std::string::npos) << words << '\n' << tight.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "result/trial.mp4"));
  const std::string session = bytes_of(folder / "result/session.json");
  EXPECT_NE(session.find("expected_ms_per_frame"), std::string::npos);
  const Outcome draft = run_with("--quality", "draft");
  EXPECT_EQ(draft.code, 0) << draft.err;
  EXPECT_NE(draft.err.find("linear estimation"), std::string::npos) << draft.err;
  EXPECT_NE(draft.err.find("the whole run took"), std::string::npos) << draft.err;
}

TEST(LoadMeterTest, SeesShares) {
  const LoadMeter meter;
  double sum = 0.0;
  for (int k = 0; k < 3000000; ++k) sum += std::sqrt(static_cast<double>(k));
  EXPECT_GT(sum, 0.0);
  EXPECT_GE(meter.share_of_others(), 0.0);
  EXPECT_LE(meter.share_of_others(), 1.0);
}

}  // namespace
}  // namespace zygoma
