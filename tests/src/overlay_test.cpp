// The overlay: colours in order, close-ups that hold the head still, what is lost is said.
#include "src/pipeline/overlay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/pipeline/overlay_view.h"
#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

constexpr int kNumFrames = 3;
const cv::Size kVideo(400, 300);

// Where the head is in a frame: it moves, turns and comes nearer.
Similarity head_of(int frame) {
  const double angle = 0.12 * frame;
  const double scale = 0.8 + 0.15 * frame;
  const Similarity turn{scale * std::cos(angle), scale * std::sin(angle), Point2::Zero()};
  const Point2 middle = turn.apply(chart_point(0.0, 0.6));
  return {turn.a, turn.b, Point2(200.0 + 9.0 * frame, 150.0 - 5.0 * frame) - middle};
}

// A pattern that is fixed to the head.
cv::Mat picture_of(int frame) {
  const Similarity chart_from_image = head_of(frame).inverse();
  cv::Mat picture(kVideo, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const Point2 p = chart_from_image.apply(Point2(x, y));
      const double value = 128.0 + 60.0 * std::sin(0.21 * p.x()) * std::cos(0.17 * p.y());
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<unsigned char>(value));
    }
  }
  return picture;
}

struct Track {
  std::vector<ContourSet> contours;
  std::vector<std::optional<Similarity>> heads;
};

Track track_of(const std::string& lost = {}) {
  Track track;
  for (int frame = 0; frame < kNumFrames; ++frame) {
    ContourSet set;
    set.frame_index = frame;
    for (const Feature& feature : kFeatureSchema) {
      Contour contour{std::string(feature.name), {}, 0.0, false};
      if (feature.name != lost) {
        contour.confidence = 0.9;
        contour.points_px = {head_of(frame).apply(chart_point(-0.2, 0.4)),
                             head_of(frame).apply(chart_point(0.2, 0.4))};
      }
      set.contours.push_back(contour);
    }
    track.contours.push_back(set);
    track.heads.emplace_back(head_of(frame));
  }
  return track;
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat apart;
  cv::absdiff(a, b, apart);
  return cv::mean(apart)[1];
}

TEST(ConfidenceColour, GrowsBrighterWithConfidence) {
  double before = -1.0;
  for (int i = 0; i <= 20; ++i) {
    const cv::Scalar colour = confidence_colour(i / 20.0);
    const double luminance = 0.07 * colour[0] + 0.72 * colour[1] + 0.21 * colour[2];
    EXPECT_GT(luminance, before);
    before = luminance;
  }
  EXPECT_EQ(confidence_colour(-1.0), confidence_colour(0.0));
  EXPECT_EQ(confidence_colour(7.0), confidence_colour(1.0));
}

TEST(OverlayView, CloseUpsHoldTheHeadStill) {
  const Track track = track_of();
  OverlayView view(kVideo, track.contours, track.heads);
  EXPECT_EQ(view.size_px().width % 2 + view.size_px().height % 2, 0);
  const cv::Mat first = view.draw(0, picture_of(0)).clone();
  const cv::Mat last = view.draw(2, picture_of(2)).clone();
  ASSERT_EQ(first.size(), view.size_px());
  // Without the rulers, whose length follows the head's size.
  const cv::Rect brow(view.size_px().width - 600, 40, 260, 200);
  const cv::Rect mouth(view.size_px().width - 600, 340, 560, 240);
  const cv::Rect video(40, 60, 400, 400);
  EXPECT_GT(difference(first(video), last(video)), 15.0);
  EXPECT_LT(difference(first(brow), last(brow)), 2.5);
  EXPECT_LT(difference(first(mouth), last(mouth)), 2.5);
  cv::Scalar mean, spread;
  cv::meanStdDev(first(mouth), mean, spread);
  EXPECT_GT(spread[1], 15.0) << "there is something to be still";
}

TEST(OverlayView, SaysWhatIsLost) {
  const Track whole = track_of();
  const Track without = track_of("hairline");
  Track none = track_of();
  none.heads.assign(kNumFrames, std::nullopt);
  for (ContourSet& set : none.contours) {
    for (Contour& contour : set.contours) contour = {contour.name, {}, 0.0, false};
  }
  std::vector<cv::Mat> views;
  for (const Track* track : std::initializer_list<const Track*>{&whole, &without, &none}) {
    OverlayView view(kVideo, track->contours, track->heads);
    views.push_back(view.draw(1, picture_of(1)).clone());
  }
  // Beside the scale of colours, below the mouth.
  const cv::Size size = views[0].size();
  const cv::Rect words(size.width - 380, size.height - 70, 370, 50);
  cv::Scalar mean, spread;
  cv::meanStdDev(views[0](words), mean, spread);
  EXPECT_EQ(spread[2], 0.0) << "nothing is lost";
  EXPECT_GT(difference(views[0](words), views[1](words)), 0.2);
  EXPECT_GT(difference(views[1](words), views[2](words)), 0.2);
}

TEST(OverlayView, TakesVideosOfAnyShape) {
  const Track track = track_of();
  for (const cv::Size size : {cv::Size(1920, 1080), cv::Size(90, 640), cv::Size(640, 17)}) {
    OverlayView view(size, track.contours, track.heads);
    const cv::Mat& drawn = view.draw(0, cv::Mat(size, CV_8UC3, cv::Scalar::all(90)));
    EXPECT_EQ(drawn.rows, 768);
    EXPECT_LE(drawn.cols, 1640);
  }
}

}  // namespace
}  // namespace zygoma
