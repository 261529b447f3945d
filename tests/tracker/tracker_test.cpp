#include "tracker/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"
#include "tracker/initialiser.h"

namespace zygoma {
namespace {

// A drawn face: an ellipse of skin with brows, eyes, nose, lips, hair and some fixed texture, in
// eye distances about the eye middle. Parts can be moved by hand.
struct Drawing {
  Point2 eye_middle_px{160.0, 110.0};
  double eye_distance_px = 64.0;
  double brow_up = 0.0;     // eye distances
  double mouth_open = 0.0;  // the lower lip and the chin go down by this
  double mouth_wide = 0.0;  // added to the half width
};

class Painter {
 public:
  explicit Painter(const Drawing& d) : d_(d), image_(320, 320, CV_8UC3, cv::Scalar(150, 120, 90)) {}
  void polygon(const std::vector<Point2>& points, const cv::Scalar& colour) {
    std::vector<cv::Point> fixed;
    for (const Point2& p : points) {
      const Point2 q = 16.0 * place(p);
      fixed.emplace_back(static_cast<int>(std::lround(q.x())),
                         static_cast<int>(std::lround(q.y())));
    }
    cv::fillPoly(image_, std::vector<std::vector<cv::Point>>{fixed}, colour, cv::LINE_AA, 4);
  }
  void ellipse(double x, double y, double a, double b, const cv::Scalar& colour) {
    std::vector<Point2> points;
    for (int i = 0; i < 60; ++i) {
      const double t = 2.0 * 3.14159265358979 * i / 60.0;
      points.emplace_back(x + a * std::cos(t), y + b * std::sin(t));
    }
    polygon(points, colour);
  }
  Point2 place(const Point2& p) const { return d_.eye_middle_px + d_.eye_distance_px * p; }
  cv::Mat image() {
    cv::Mat out;
    cv::GaussianBlur(image_, out, cv::Size(), 0.8);
    return out;
  }

 private:
  Drawing d_;
  cv::Mat image_;
};

cv::Mat draw(const Drawing& d) {
  Painter p(d);
  const cv::Scalar skin(140, 165, 205), hair(25, 30, 40), lip(95, 90, 175), dark(40, 40, 70);
  p.ellipse(0.0, 0.35, 1.18, 1.75, hair);
  p.ellipse(0.0, 0.5 + 0.15 * d.mouth_open, 1.05, 1.45 + 0.3 * d.mouth_open, skin);
  for (const double side : {-1.0, 1.0}) {
    p.ellipse(side * 0.5, 0.0, 0.22, 0.09, cv::Scalar(235, 235, 235));
    p.ellipse(side * 0.5, 0.0, 0.085, 0.085, dark);
    std::vector<Point2> brow;
    for (int i = 0; i <= 20; ++i) {
      const double t = i / 20.0;
      brow.emplace_back(side * (0.23 + 0.7 * t), -0.4 - d.brow_up - 0.08 * std::sin(2.6 * t));
    }
    for (int i = 20; i >= 0; --i)
      brow.emplace_back(brow[static_cast<size_t>(i)] + Point2(0.0, 0.11));
    p.polygon(brow, cv::Scalar(45, 55, 70));
    p.ellipse(side * 0.1, 0.74, 0.06, 0.035, dark);
    p.ellipse(side * 0.21, 0.66, 0.035, 0.07, cv::Scalar(110, 135, 180));
    // Freckles: something rigid to follow.
    for (int i = 0; i < 6; ++i) {
      p.ellipse(
          side * (0.12 + 0.1 * (i % 3)), 0.15 + 0.13 * i, 0.014, 0.014, cv::Scalar(100, 130, 175));
    }
  }
  std::vector<Point2> mouth;
  const double w = 0.38 + d.mouth_wide;
  for (int i = 0; i <= 24; ++i) {
    const double s = i / 12.0 - 1.0;
    mouth.emplace_back(w * s, 1.15 - 0.13 * (1.0 - s * s));
  }
  for (int i = 24; i >= 0; --i) {
    const double s = i / 12.0 - 1.0;
    mouth.emplace_back(w * s, 1.15 + (0.16 + d.mouth_open) * (1.0 - s * s));
  }
  p.polygon(mouth, lip);
  p.ellipse(0.0, 1.15 + 0.5 * d.mouth_open, 0.9 * w, 0.012 + 0.45 * d.mouth_open, dark);
  return p.image();
}

// The template's contours where the drawing is.
ContourSet template_at(const Drawing& d) {
  const Similarity place = image_from_chart(d.eye_middle_px - Point2(0.5 * d.eye_distance_px, 0.0),
                                            d.eye_middle_px + Point2(0.5 * d.eye_distance_px, 0.0));
  ContourSet set;
  const ContourNodes nodes = template_contours();
  for (const size_t f : {kBrowLeft, kBrowRight, kNoseTip, kChinBoss}) {
    Contour contour;
    contour.name = kFeatureSchema[f].name;
    contour.confidence = 1.0;
    for (const Point2& p : nodes[f]) contour.points_px.push_back(place.apply(p));
    set.contours.push_back(contour);
  }
  return set;
}

Frame frame_of(int index, const cv::Mat& image) { return Frame{index, index / 25.0, image}; }

double mean_y(const ContourSet& set, const char* name) {
  const Contour* contour = set.visible(name);
  if (contour == nullptr) return std::nan("");
  double sum = 0.0;
  for (const Point2& p : contour->points_px) sum += p.y();
  return sum / static_cast<double>(contour->points_px.size());
}

void expect_well_formed(const ContourSet& set) {
  ASSERT_EQ(set.contours.size(), kFeatureSchema.size());
  for (size_t f = 0; f < kFeatureSchema.size(); ++f) {
    const Contour& contour = set.contours[f];
    EXPECT_EQ(contour.name, kFeatureSchema[f].name);
    EXPECT_GE(contour.confidence, 0.0);
    EXPECT_LE(contour.confidence, 1.0);
    EXPECT_EQ(contour.lost(), contour.confidence == 0.0) << contour.name;
    if (!contour.lost()) {
      EXPECT_EQ(static_cast<int>(contour.points_px.size()), kFeatureSchema[f].num_nodes);
    }
    for (const Point2& p : contour.points_px) EXPECT_TRUE(p.allFinite());
  }
}

TEST(Tracker, FindsNothingInPicturesWithoutAFace) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(16, 16), cv::Size(320, 240)}) {
    for (const int grey : {0, 128, 255}) {
      Tracker tracker;
      for (int i = 0; i < 2; ++i) {
        const ContourSet set =
            tracker.track(frame_of(i, cv::Mat(size, CV_8UC3, cv::Scalar::all(grey))));
        expect_well_formed(set);
        EXPECT_EQ(set.frame_index, i);
        EXPECT_EQ(tracker.report().num_lost, static_cast<int>(kNumFeatures));
        EXPECT_FALSE(tracker.report().face_found);
      }
    }
  }
}

TEST(Tracker, EmptyPictureIsNoFace) {
  Tracker tracker;
  expect_well_formed(tracker.track(Frame{}));
  EXPECT_EQ(tracker.report().num_lost, static_cast<int>(kNumFeatures));
}

TEST(Tracker, RefusesOptionsAndFoldersByName) {
  TrackerOptions options;
  options.flow_hold = -1.0;
  EXPECT_THROW(Tracker{options}, InputError);
  TrackerOptions elsewhere;
  elsewhere.cascade_folder = "/no/such/folder";
  Tracker tracker(elsewhere);
  EXPECT_THROW(tracker.track(frame_of(0, draw({}))), InputError);
}

TEST(Tracker, StillPictureDoesNotCreep) {
  Tracker tracker;
  const cv::Mat image = draw({});
  tracker.start_from(template_at({}));
  ContourSet settled;
  for (int i = 0; i < 60; ++i) {
    const ContourSet set = tracker.track(frame_of(i, image));
    expect_well_formed(set);
    ASSERT_TRUE(tracker.report().face_found);
    if (i == 30) settled = set;
    if (i != 59) continue;
    for (size_t f = 0; f < set.contours.size(); ++f) {
      for (size_t n = 0; n < set.contours[f].points_px.size(); ++n) {
        EXPECT_LT((set.contours[f].points_px[n] - settled.contours[f].points_px[n]).norm(), 0.05)
            << set.contours[f].name << " node " << n;
      }
    }
  }
}

TEST(Tracker, FollowsBrowsMouthAndHead) {
  Tracker tracker;
  Drawing d;
  tracker.start_from(template_at(d));
  ContourSet before, after;
  for (int i = 0; i <= 40; ++i) {
    const double s = i < 10 ? 0.0 : (i - 10) / 30.0;
    Drawing now = d;
    now.eye_middle_px += Point2(20.0 * s, 8.0 * s);
    now.brow_up = 0.12 * s;
    now.mouth_open = 0.25 * s;
    const ContourSet set = tracker.track(frame_of(i, draw(now)));
    ASSERT_TRUE(tracker.report().face_found);
    if (i == 10) before = set;
    after = set;
  }
  const auto moved = [&](const char* name) {
    return mean_y(after, name) - mean_y(before, name) - 8.0;
  };
  EXPECT_NEAR(moved("brow_left"), -0.12 * 64.0, 1.5);
  EXPECT_NEAR(moved("brow_right"), -0.12 * 64.0, 1.5);
  EXPECT_NEAR(moved("nose_tip"), 0.0, 1.0);
  EXPECT_NEAR(moved("upper_lip"), 0.0, 2.0);
  EXPECT_GT(moved("lower_lip"), 5.0);
  const Contour* lip = after.visible("upper_lip");
  ASSERT_NE(lip, nullptr);
  EXPECT_NEAR(0.5 * (lip->points_px.front().x() + lip->points_px.back().x()), 180.0, 2.0);
}

TEST(Tracker, MirroredFaceGivesMirroredContours) {
  Drawing d;
  d.eye_middle_px = Point2(159.5, 110.0);
  const cv::Mat image = draw(d);
  cv::Mat mirrored;
  cv::flip(image, mirrored, 1);
  Tracker one, two;
  one.start_from(template_at(d));
  two.start_from(template_at(d));
  const ContourSet a = one.track(frame_of(0, image));
  const ContourSet b = two.track(frame_of(0, mirrored));
  const Contour* left = a.visible("brow_left");
  const Contour* right = b.visible("brow_right");
  ASSERT_TRUE(left != nullptr && right != nullptr);
  for (size_t i = 0; i < left->points_px.size(); ++i) {
    const Point2 flipped(319.0 - right->points_px[i].x(), right->points_px[i].y());
    EXPECT_LT((left->points_px[i] - flipped).norm(), 1.0);
  }
}

TEST(Tracker, ExplicitSteppingComesToTheSamePlaces) {
  ContourSet last[2];
  for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
    TrackerOptions options;
    options.stepping = stepping;
    Tracker tracker(options);
    tracker.start_from(template_at({}));
    for (int i = 0; i < 8; ++i) {
      Drawing d;
      d.mouth_open = 0.03 * i;
      last[stepping == SnakeStepping::kExplicit] = tracker.track(frame_of(i, draw(d)));
    }
  }
  for (size_t f = 0; f < last[0].contours.size(); ++f) {
    for (size_t n = 0; n < last[0].contours[f].points_px.size(); ++n) {
      EXPECT_LT((last[0].contours[f].points_px[n] - last[1].contours[f].points_px[n]).norm(), 0.3)
          << last[0].contours[f].name << " node " << n;
    }
  }
}

// How far the left brow is from where it should be, after it has gone up at once.
double brow_left_behind_px(const TrackerEffort& effort, double flow_hold = 0.3) {
  TrackerOptions options;
  options.flow_hold = flow_hold;
  options.effort = effort;
  Tracker tracker(options);
  tracker.start_from(template_at({}));
  double before = 0.0;
  for (int i = 0; i < 4; ++i) before = mean_y(tracker.track(frame_of(i, draw({}))), "brow_left");
  Drawing raised;
  raised.brow_up = 0.1;
  ContourSet set;
  for (int i = 4; i < 6; ++i) set = tracker.track(frame_of(i, draw(raised)));
  return std::abs(mean_y(set, "brow_left") - (before - raised.brow_up * raised.eye_distance_px));
}

TEST(Tracker, WhatIsNotPredictedIsLeftBehind) {
  TrackerEffort effort;
  EXPECT_LT(brow_left_behind_px(effort), 1.5);
  effort.predict_by = PredictBy::kLastFrame;
  EXPECT_LT(brow_left_behind_px(effort), 1.5);
  effort.predict_by = PredictBy::kNothing;
  const double alone_px = brow_left_behind_px(effort, 0.0);
  EXPECT_GT(alone_px, 3.0);
  effort.gaussian_levels = 3;  // attract from further away
  EXPECT_LT(brow_left_behind_px(effort, 0.0), 0.8 * alone_px);
}

TEST(Tracker, EffortIsPaidInIterationsAndHardlyMovesContours) {
  const auto follow = [](const TrackerEffort& effort, int& iterations) {
    TrackerOptions options;
    options.effort = effort;
    Tracker tracker(options);
    tracker.start_from(template_at({}));
    ContourSet set;
    for (int i = 0; i < 6; ++i) {
      Drawing d;
      d.mouth_open = 0.03 * i;
      set = tracker.track(frame_of(i, draw(d)));
    }
    iterations = tracker.report().relax_iterations;
    return set;
  };
  int usual_iterations = 0;
  const ContourSet usual = follow({}, usual_iterations);
  const auto expect_near = [&](const TrackerEffort& effort, int& iterations) {
    const ContourSet set = follow(effort, iterations);
    for (size_t f = 0; f < kContours1992.size(); ++f) {
      ASSERT_EQ(set.contours[f].points_px.size(), usual.contours[f].points_px.size());
      for (size_t n = 0; n < set.contours[f].points_px.size(); ++n) {
        EXPECT_LT((set.contours[f].points_px[n] - usual.contours[f].points_px[n]).norm(), 3.0)
            << set.contours[f].name << " node " << n;
      }
    }
  };
  int iterations = 0;
  TrackerEffort effort;
  effort.max_iterations = 1;
  expect_near(effort, iterations);
  EXPECT_EQ(iterations, static_cast<int>(kNumFeatures));
  effort = {};
  effort.tolerance_px = 1e-5;
  effort.max_iterations = 1000;
  expect_near(effort, iterations);
  EXPECT_GT(iterations, usual_iterations);
  effort = {};
  effort.nodes = 2.0;
  expect_near(effort, iterations);
  effort = {};
  effort.models = false;
  expect_near(effort, iterations);
}

TEST(Tracker, OptionsOutOfRangeAreRefusedByName) {
  const double nan = std::nan("");
  const auto expect_refused = [](const char* name, const auto& spoil) {
    TrackerOptions options;
    options.check();
    spoil(options);
    try {
      options.check();
      ADD_FAILURE() << name << " went through";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  expect_refused("gaussian_levels", [](TrackerOptions& o) { o.effort.gaussian_levels = 0; });
  expect_refused("nodes", [](TrackerOptions& o) { o.effort.nodes = 0.1; });
  expect_refused("tolerance_px", [&](TrackerOptions& o) { o.effort.tolerance_px = nan; });
  expect_refused("max_iterations", [](TrackerOptions& o) { o.effort.max_iterations = 0; });
  expect_refused("max_coast_frames", [](TrackerOptions& o) { o.max_coast_frames = -1; });
  expect_refused("flow_hold", [](TrackerOptions& o) { o.flow_hold = -0.1; });
  expect_refused("model_share", [](TrackerOptions& o) { o.model_share = 1.1; });
  expect_refused("model_share", [&](TrackerOptions& o) { o.model_share = nan; });
  expect_refused("prior_share", [](TrackerOptions& o) { o.prior_share = -0.1; });
  expect_refused("sharper", [](TrackerOptions& o) { o.sharper = 1.0; });
  expect_refused("sharper", [&](TrackerOptions& o) { o.sharper = nan; });
  expect_refused("new_look_correlation", [](TrackerOptions& o) { o.new_look_correlation = 1.0; });
}

TEST(Tracker, SaysWhyAConfidenceIsLow) {
  Tracker tracker;
  tracker.start_from(template_at({}));
  ContourSet set;
  for (int i = 0; i < 8; ++i) {
    cv::Mat image = draw({});
    if (i > 4)
      cv::rectangle(image, cv::Rect(110, 160, 100, 50), cv::Scalar(90, 20, 20), cv::FILLED);
    set = tracker.track(frame_of(i, image));
  }
  for (size_t f = 0; f < set.contours.size(); ++f) {
    const ConfidenceTerms& terms = tracker.report().terms[f];
    const ConfidenceMap& map = confidence_map(set.contours[f].name);
    EXPECT_NEAR(set.contours[f].confidence, confidence_of(map, terms), 1e-12);
    if (set.contours[f].name != "upper_lip") continue;
    EXPECT_LT(set.contours[f].confidence, 0.5);
    EXPECT_LT(terms[weakest_term(map, terms)], 0.5);
  }
}

TEST(Tracker, SameBitsOnRepetition) {
  ContourSet last[2];
  for (ContourSet& out : last) {
    Tracker tracker;
    tracker.start_from(template_at({}));
    for (int i = 0; i < 8; ++i) {
      Drawing d;
      d.mouth_open = 0.03 * i;
      out = tracker.track(frame_of(i, draw(d)));
    }
  }
  EXPECT_EQ(last[0], last[1]);
}

TEST(Tracker, BlackFramesEndTheTrackAndAFaceResumesIt) {
  TrackerOptions options;
  options.max_coast_frames = 2;
  Tracker tracker(options);
  const cv::Mat face = draw({});
  tracker.start_from(template_at({}));
  for (int i = 0; i < 5; ++i) tracker.track(frame_of(i, face));
  ASSERT_TRUE(tracker.report().face_found);
  const cv::Mat black(320, 320, CV_8UC3, cv::Scalar::all(0));
  for (int i = 5; i < 10; ++i) expect_well_formed(tracker.track(frame_of(i, black)));
  EXPECT_FALSE(tracker.report().face_found);
  EXPECT_EQ(tracker.report().num_lost, static_cast<int>(kNumFeatures));
}

}  // namespace
}  // namespace zygoma
