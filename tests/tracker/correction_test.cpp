// Springs, pins and volcanoes on a track of pictures that stand still.
#include "tracker/correction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "tests/support/two_bands.h"
#include "tracker/initialiser.h"

namespace zygoma {
namespace {

TEST(CorrectionTest, WithoutEventsNothingChanges) {
  EXPECT_TRUE(reach_of({}, kNumFrames).empty());
  EXPECT_EQ(corrected({}), automatic_track());
}

TEST(CorrectionTest, ASpringHoldsTheContourInItsFrame) {
  const std::vector<ContourSet> track = corrected({pull(kBrowRow - 3.0)});
  const Contour& brow = track[kCorrected].contours[kBrowLeft];
  EXPECT_NEAR(brow.points_px[4].y(), kBrowRow - 3.0, 0.5);
  EXPECT_TRUE(brow.locked);
  EXPECT_EQ(brow.confidence, 1.0);
}

TEST(CorrectionTest, ActsUntilTheNextCorrectionOfTheContour) {
  Correction back = pull(kBrowRow);
  back.id = 2;
  back.frame = kCorrected + 10;
  const std::vector<ContourSet> track = corrected({pull(kOtherRow), back});
  EXPECT_NEAR(middle_row(track[kCorrected]), kOtherRow, 1.0);
  EXPECT_NEAR(middle_row(track[kCorrected + 10]), kBrowRow, 1.0);
  EXPECT_EQ(track[kCorrected + 15], automatic_track()[kCorrected + 15]);
  for (int k = kCorrected; k < kCorrected + 10; ++k) {  // blended in between
    EXPECT_LE(middle_row(track[k + 1]), middle_row(track[k]) + 0.2) << k;
  }
}

TEST(CorrectionTest, APinHoldsInTheFramesAround) {
  const std::vector<ContourSet> track = corrected({pull(kBrowRow - 2.5, MouseForce::kPin)});
  for (const int k : {kCorrected - 10, kCorrected + 5, kCorrected + 20}) {
    EXPECT_NEAR(middle_row(track[k]), kBrowRow - 2.5, 1.0) << k;
    EXPECT_TRUE(track[k].contours[kBrowLeft].locked) << k;
  }
}

TEST(CorrectionTest, AVolcanoPushesTheContourToTheOtherEdge) {
  Correction volcano = pull(kBrowRow - 2.0, MouseForce::kVolcano);
  volcano.stiffness = 30.0;
  const std::vector<ContourSet> track = corrected({volcano});
  EXPECT_GT(middle_row(track[kCorrected]), kOtherRow - 4.0);
}

TEST(CorrectionTest, EndsWhereTheFaceIsLost) {
  std::vector<FaceChart> all = charts();
  all[kCorrected + 3] = {};
  std::vector<ContourSet> track = automatic_track();
  const std::vector<Correction> corrections{pull(kOtherRow)};
  apply_corrections(corrections, {0, kNumFrames - 1}, all, LipMap(), track);
  EXPECT_NEAR(middle_row(track[kCorrected + 2]), kOtherRow, 1.5);
  EXPECT_EQ(track[kCorrected + 3], automatic_track()[kCorrected + 3]);
  EXPECT_EQ(track[kCorrected + 4], automatic_track()[kCorrected + 4]);
}

TEST(CorrectionTest, JoinsOverlappingReaches) {
  Correction late = pull(kBrowRow);
  late.frame = 1000;
  const std::vector<FrameRange> ranges = reach_of({late, pull(kBrowRow)}, 2000);
  ASSERT_EQ(ranges.size(), 2U);
  EXPECT_EQ(ranges[0].first, 0);
  EXPECT_EQ(ranges[0].last, kCorrected + kCorrectionReach);
  EXPECT_EQ(ranges[1].first, 1000 - kCorrectionReach);
  late.frame = kCorrected + 2 * kCorrectionReach;
  EXPECT_EQ(reach_of({late, pull(kBrowRow)}, 2000).size(), 1U);
  EXPECT_THROW(reach_of({late}, 100), InputError);
}

TEST(CorrectionTest, RefusesValuesOutOfRange) {
  const auto refused = [](auto change) {
    Correction correction = pull(kBrowRow);
    change(correction);
    EXPECT_THROW(correction.check(), InputError);
  };
  refused([](Correction& c) { c.frame = -1; });
  refused([](Correction& c) { c.contour = "nose"; });
  refused([](Correction& c) { c.along = 1.5; });
  refused([](Correction& c) { c.stiffness = 0.0; });
  refused([](Correction& c) { c.radius = 0.0; });
  refused([](Correction& c) { c.radius = 2.0; });
  refused([](Correction& c) { c.at_px.x() = std::nan(""); });
  EXPECT_NO_THROW(pull(kBrowRow).check());
}

}  // namespace
}  // namespace zygoma
