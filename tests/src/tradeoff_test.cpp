#include "src/pipeline/tradeoff.h"

#include <gtest/gtest.h>

#include "src/base/check.h"
#include "src/pipeline/pick_quality.h"
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

TissueChoice choice(int vertices, bool bi_layer, double residual) {
  return {"", {"", vertices, bi_layer, residual, 0.0}, Solver::kImplicit};
}

TEST(TradeoffTest, FinerIsCloserAndTheReferenceIsItself) {
  SilentObserver silent;
  const TissueChoice reference = choice(1000, false, 1e-6);
  const Tradeoff tradeoff =
      measure_tradeoff(short_scene(),
                       {choice(300, false, 1e-4), choice(500, false, 1e-4), reference},
                       reference,
                       silent,
                       {});
  ASSERT_EQ(tradeoff.rows.size(), 3U);
  double coarse = 0.0, finer = 0.0, same = 1.0;
  for (const TradeoffRow& row : tradeoff.rows) {
    EXPECT_EQ(row.frames_not_converged, 0);
    EXPECT_GT(row.frame_ms, 0.0);
    EXPECT_GE(row.largest_mm, row.rms_mm);
    const int vertices = row.choice.quality.surface_vertices;
    (vertices == 300 ? coarse : vertices == 500 ? finer : same) = row.rms_mm;
  }
  EXPECT_EQ(same, 0.0);
  EXPECT_GT(finer, 0.01);
  EXPECT_LT(finer, coarse);
  EXPECT_LT(coarse, 3.0);  // of a corner of the mouth that moves by 10
}

TEST(TradeoffTest, TheFrontFallsWithTime) {
  SilentObserver silent;
  const Tradeoff tradeoff =
      measure_tradeoff(short_scene(),
                       {choice(300, true, 1e-2), choice(300, false, 1e-2), choice(500, true, 1e-2)},
                       choice(1000, true, 1e-4),
                       silent,
                       {});
  double time = 0.0, error = 1e9;
  int on_front = 0;
  for (const TradeoffRow& row : tradeoff.rows) {
    EXPECT_GE(row.frame_ms, time);
    time = row.frame_ms;
    if (!row.on_front) {
      EXPECT_GE(row.rms_mm, error);
      continue;
    }
    ++on_front;
    EXPECT_LT(row.rms_mm, error);
    error = row.rms_mm;
  }
  EXPECT_GE(on_front, 1);
  const ScratchFolder folder;
  write_tradeoff_csv(folder / "tradeoff.csv", tradeoff);
  write_tradeoff_plot(folder / "tradeoff.svg", tradeoff);
  EXPECT_GT(std::filesystem::file_size(folder / "tradeoff.csv"), 300U);
  EXPECT_GT(std::filesystem::file_size(folder / "tradeoff.svg"), 1000U);
}

TEST(TradeoffTest, StopsWhenAsked) {
  SilentObserver silent;
  int asked = 0;
  const Tradeoff tradeoff = measure_tradeoff(short_scene(),
                                             {choice(300, true, 1e-2), choice(300, false, 1e-2)},
                                             choice(300, true, 1e-4),
                                             silent,
                                             [&] { return ++asked > 8; });
  EXPECT_TRUE(tradeoff.stopped);
  EXPECT_LT(tradeoff.rows.size(), 2U);
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
  EXPECT_TRUE(fine.fits);
  EXPECT_EQ(pick_for_tolerance(1e-6).quality.name, "reference");
  double error = 1e9;
  for (const FaceQuality& quality : face_qualities()) {
    EXPECT_LT(quality.expected_rms_mm, error) << quality.name;
    error = quality.expected_rms_mm;
  }
}

}  // namespace
}  // namespace zygoma
