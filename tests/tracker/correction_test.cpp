// Springs, pins and volcanoes on a track of pictures that stand still.
#include "tracker/correction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "tracker/initialiser.h"

namespace zygoma {
namespace {

constexpr double kBrowRow = 80.0;   // brightness falls downwards here ...
constexpr double kOtherRow = 92.0;  // ... and here
constexpr int kNumFrames = 40;
constexpr int kCorrected = 15;

// Two dark bands right across the chart: two edges that look like the upper edge of a brow.
FaceChart two_bands() {
  cv::Mat image(kChartHeight, kChartWidth, CV_8UC3, cv::Scalar::all(180));
  for (const double row : {kBrowRow, kOtherRow}) {
    cv::rectangle(image,
                  cv::Point(0, static_cast<int>(row) + 1),
                  cv::Point(kChartWidth, static_cast<int>(row) + 6),
                  cv::Scalar::all(60),
                  cv::FILLED);
  }
  cv::GaussianBlur(image, image, cv::Size(), 1.0);
  return make_face_chart(image, Similarity{});
}

std::vector<FaceChart> charts() { return std::vector<FaceChart>(kNumFrames, two_bands()); }

// The left brow on the first band, everything else lost.
std::vector<ContourSet> automatic_track() {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) nodes.emplace_back(110.0 + 5.0 * i, kBrowRow + 0.5);
  std::vector<ContourSet> track(kNumFrames);
  for (int k = 0; k < kNumFrames; ++k) {
    track[k].frame_index = k;
    for (const Feature& feature : kFeatureSchema) {
      track[k].contours.push_back({std::string(feature.name), {}, 0.0, false});
    }
    track[k].contours[kBrowLeft].points_px = nodes;
    track[k].contours[kBrowLeft].confidence = 0.5;
  }
  return track;
}

Correction pull(double to_row, MouseForce force = MouseForce::kSpring) {
  Correction correction;
  correction.id = 1;
  correction.frame = kCorrected;
  correction.contour = "brow_left";
  correction.force = force;
  correction.along = 0.5;
  correction.at_px = {130.0, to_row};
  correction.stiffness = 8.0;
  correction.radius = force == MouseForce::kVolcano ? 20.0 : 1.0;
  return correction;
}

std::vector<ContourSet> corrected(const std::vector<Correction>& corrections) {
  std::vector<ContourSet> track = automatic_track();
  for (const FrameRange& range : reach_of(corrections, kNumFrames)) {
    std::vector<FaceChart> all = charts();
    apply_corrections(corrections,
                      range,
                      {all.begin() + range.first, all.begin() + range.last + 1},
                      LipMap(),
                      track);
  }
  return track;
}

double middle_row(const ContourSet& set) { return set.contours[kBrowLeft].points_px[4].y(); }

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

// HC-74: no ridge was crossed, so the frames around fall back onto their edge and, a few frames on,
// keep the bits of the automatic track.
TEST(CorrectionTest, PulledWithoutCrossingARidgeTheContourComesBack) {
  const std::vector<ContourSet> automatic = automatic_track();
  const std::vector<ContourSet> track = corrected({pull(kBrowRow - 2.5)});
  EXPECT_GT(std::abs(middle_row(track[kCorrected]) - middle_row(automatic[0])), 1.5);
  int touched = 0;
  for (int k = 0; k < kNumFrames; ++k) {
    if (k == kCorrected || track[k] == automatic[k]) continue;
    ++touched;
    EXPECT_LT(std::abs(k - kCorrected), 8) << k;
    EXPECT_FALSE(track[k].contours[kBrowLeft].locked);
  }
  EXPECT_LT(touched, 14);
}

// HC-75: dragged over to the other band the contour stays there, in both directions of time.
TEST(CorrectionTest, DraggedAcrossARidgeTheContourStaysThere) {
  const std::vector<ContourSet> track = corrected({pull(kOtherRow)});
  for (int k = 0; k < kNumFrames; ++k) EXPECT_NEAR(middle_row(track[k]), kOtherRow, 1.5) << k;
  EXPECT_EQ(track, corrected({pull(kOtherRow)})) << "replay differs";
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
