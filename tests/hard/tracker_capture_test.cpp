// How far a face may move between two pictures: with the snake alone, as in 1992, with flow before
// it, and with the whole tracker, which takes the motion of the head off first.
//
//   ZYGOMA_CAPTURE_PLOT=docs/capture_range.svg build/release/tests/hard_tests
//   --gtest_filter='HC60.*'
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "src/io/svg_plot.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/evidence.h"
#include "tracker/face_chart.h"
#include "tracker/initialiser.h"
#include "tracker/predictor.h"
#include "tracker/snake.h"

namespace zygoma::hard {
namespace {

constexpr int kNumSteps = 12;
constexpr std::array<FeatureIndex, 5> kFollowed{
    kBrowLeft, kBrowRight, kNoseTip, kUpperLip, kLowerLip};

// There and back again, in eight directions.
Point2 place_at(int step, double speed_px) {
  if (step % 2 == 0) return Point2::Zero();
  const double angle = 0.7854 * (step / 2) + 0.3;
  return speed_px * Point2(std::cos(angle), std::sin(angle));
}

struct Following {
  double error = 0.0;     // chart px, mean over contours and steps
  double evidence = 0.0;  // under the contours, against that at the start; or their confidence
};

// A still face whose chart moves under the contours.
Following follow_in_chart(const Clip& clip, double speed_px, bool predict) {
  const cv::Mat& picture = clip.frames[0].image;
  Tracker tracker;
  tracker.track(clip.frames[0]);
  const Similarity head = *tracker.head();
  const auto chart_at = [&](const Point2& shift) {
    return make_face_chart(picture, head.after(Similarity{1.0, 0.0, -shift}));
  };
  FaceChart last = chart_at(Point2::Zero());
  const PlacedFace placed = place_contours(last);
  const LipMap& lips = placed.lips;
  ContourNodes right = placed.contours;  // moves with the face
  std::array<double, kNumFeatures> usual{};
  Following out;
  Point2 before = Point2::Zero();
  for (int step = 0; step <= kNumSteps; ++step) {
    const Point2 shift = place_at(step, speed_px);
    const FaceChart chart = chart_at(shift);
    EvidenceOptions places;  // move with the face: only the contour itself is studied
    places.nose_base_px += shift.y();
    places.mouth_line_px += shift.y();
    const Evidence evidence = make_evidence(chart, lips, places);
    for (const FeatureIndex f : kFollowed) {
      // Every step is judged alone: from the right place in the picture before.
      std::vector<Point2> nodes = right[f];
      if (predict && step > 0) {
        nodes = follow_points(last.pyramid, chart.pyramid, nodes, nodes).points_px;
      }
      Snake snake(nodes, snake_options(f));
      const ContourLandscape landscape(evidence, f, nodes);
      snake.relax(&landscape);
      nodes = resample(snake.nodes(), static_cast<int>(nodes.size()));
      if (step == 0) {
        // Where it settles on the first picture is where it belongs.
        right[f] = nodes;
        usual[f] = evidence_under(evidence, f, nodes);
        continue;
      }
      for (Point2& p : right[f]) p += shift - before;
      constexpr double kShare = 1.0 / (kNumSteps * kFollowed.size());
      out.error += kShare * distance_px(nodes, right[f]);
      out.evidence += kShare * evidence_under(evidence, f, nodes) / usual[f];
    }
    before = shift;
    last = chart;
  }
  return out;
}

// The whole tracker on a picture that moves.
Following follow_in_picture(const Clip& clip, double speed_px) {
  Tracker tracker;
  ContourSet right;
  Following out;
  double usual = 0.0;
  int lost = 0;
  for (int step = 0; step <= kNumSteps; ++step) {
    const Similarity motion{1.0, 0.0, clip.chart_px * place_at(step, speed_px)};
    const ContourSet set =
        tracker.track(Frame{step, step / 25.0, moved(clip.frames[0].image, motion)});
    if (step == 0) {
      right = set;
      usual = mean_confidence(set);
      continue;
    }
    const double d = mean_distance(moved(set, motion.inverse()), right, clip.chart_px);
    if (std::isfinite(d)) {
      out.error += d;
    } else {
      ++lost;
    }
    out.evidence += mean_confidence(set) / usual / kNumSteps;
  }
  out.error /= std::max(1, kNumSteps - lost);
  return out;
}

TEST(HC60, TheCaptureRangeWithAndWithoutPrediction) {
  const Clip& clip = usual_performer();
  const std::vector<double> speeds{0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 28.0, 40.0};
  PlotSeries alone{"snake alone (1992)", speeds, {}, PlotMark::kLine, 1};
  PlotSeries flow{"flow, then snake", speeds, {}, PlotMark::kLine, 0};
  PlotSeries whole{"whole tracker", speeds, {}, PlotMark::kLine, 2};
  PlotSeries given_up{"no motion followed", speeds, speeds, PlotMark::kDashes, 4};
  PlotSeries evidence_alone = alone, evidence_flow = flow, evidence_whole = whole;
  for (const double speed : speeds) {
    const Following a = follow_in_chart(clip, speed, false);
    const Following b = follow_in_chart(clip, speed, true);
    const Following c = follow_in_picture(clip, speed);
    alone.y.push_back(a.error);
    flow.y.push_back(b.error);
    whole.y.push_back(c.error);
    evidence_alone.y.push_back(a.evidence);
    evidence_flow.y.push_back(b.evidence);
    evidence_whole.y.push_back(c.evidence);
  }
  const auto range = [&](const PlotSeries& series) {
    double largest = 0.0;
    for (size_t i = 0; i < speeds.size() && series.y[i] < 1.5; ++i) largest = speeds[i];
    return largest;
  };
  const auto row = [&](const PlotSeries& series) {
    std::string text;
    for (size_t i = 0; i < speeds.size(); ++i) {
      text += (i == 0 ? "" : ", ") + figure(series.y[i]);
    }
    return text;
  };
  record("face moves by 0.5, 1, 2, 3, 5, 7, 10, 14, 20, 28, 40 chart px per picture, snake alone",
         "error " + row(alone) + " px; evidence " + row(evidence_alone) + " of the usual",
         "measured and documented",
         Outcome::kReported);
  record("the same, flow first",
         "error " + row(flow) + " px; evidence " + row(evidence_flow),
         "prediction extends the range");
  record("the same, whole tracker",
         "error " + row(whole) + " px; confidence " + row(evidence_whole) + " of the usual",
         "prediction extends the range; loss reported beyond");
  EXPECT_GE(range(flow), 2.0 * range(alone));
  EXPECT_GE(range(whole), range(flow));
  if (const char* path = std::getenv("ZYGOMA_CAPTURE_PLOT")) {
    const PlotAxis motion{"motion between two pictures (chart px, 64 to the eye distance)", true};
    write_svg_plot(path,
                   {{"Error of the contours",
                     motion,
                     {"mean distance to the right place (chart px)", true},
                     {given_up, alone, flow, whole}},
                    {"What is seen under them",
                     motion,
                     {"evidence or confidence, share of the usual", false},
                     {evidence_alone, evidence_flow, evidence_whole}}});
  }
}

}  // namespace
}  // namespace zygoma::hard
