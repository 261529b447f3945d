// Hard cases of the whole tracker: what happens to the pictures of a performer whose contours are
// known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/feature_schema.h"

namespace zygoma::hard {
namespace {

constexpr double kStatedError_px = 2.0;  // chart px: 3 % of the eye distance
constexpr size_t kRecovery = 5;          // frames

bool all_lost(const ContourSet& set) {
  return std::all_of(
      set.contours.begin(), set.contours.end(), [](const Contour& c) { return c.lost(); });
}

void expect_well_formed(const ContourSet& set) {
  ASSERT_EQ(set.contours.size(), kFeatureSchema.size());
  for (const Contour& contour : set.contours) {
    EXPECT_EQ(contour.lost(), contour.confidence == 0.0) << contour.name;
    EXPECT_GE(contour.confidence, 0.0);
    EXPECT_LE(contour.confidence, 1.0);
    for (const Point2& p : contour.points_px) EXPECT_TRUE(p.allFinite()) << contour.name;
  }
}

// A track against the undisturbed one, over some frames.
struct Departure {
  double mean = 0.0;        // chart px, over contours and frames
  double worst = 0.0;       // of one frame's mean over contours
  double confidence = 0.0;  // against the undisturbed
  int lost = 0;             // frames without any contour
};

Departure departure(const std::vector<ContourSet>& track,
                    const std::vector<ContourSet>& undisturbed,
                    double chart_px,
                    size_t first,
                    size_t end) {
  Departure out;
  double seen = 0.0, sum = 0.0, usual = 0.0;
  for (size_t i = first; i < std::min(end, track.size()); ++i) {
    sum += mean_confidence(track[i]);
    usual += mean_confidence(undisturbed[i]);
    const double d = mean_distance(track[i], undisturbed[i], chart_px);
    if (!std::isfinite(d)) {
      ++out.lost;
      continue;
    }
    out.mean += d;
    out.worst = std::max(out.worst, d);
    seen += 1.0;
  }
  out.mean /= std::max(1.0, seen);
  out.confidence = usual > 0.0 ? sum / usual : 0.0;
  return out;
}

TEST(HC38, PicturesThatAreNoneGiveNoContours) {
  const auto lost = [](const cv::Mat& image) {
    Tracker tracker;
    const ContourSet set = tracker.track(Frame{0, 0.0, image});
    expect_well_formed(set);
    return all_lost(set);
  };
  const cv::Size size(320, 240);
  cv::Mat noise(size, CV_8UC3), dots(size, CV_8UC3, cv::Scalar::all(30));
  cv::RNG random(9);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  for (int i = 0; i < 500; ++i) {
    dots.at<cv::Vec3b>(random.uniform(0, 240), random.uniform(0, 320)) = cv::Vec3b::all(255);
  }
  cv::Mat wide;
  usual_performer().frames[0].image.convertTo(wide, CV_16UC3, 257.0);
  EXPECT_TRUE(lost(cv::Mat(size, CV_8UC3, cv::Scalar::all(0))));
  EXPECT_TRUE(lost(cv::Mat(size, CV_8UC3, cv::Scalar::all(128))));
  EXPECT_TRUE(lost(cv::Mat(size, CV_8UC3, cv::Scalar::all(255))));
  EXPECT_TRUE(lost(noise));
  EXPECT_TRUE(lost(dots));
  EXPECT_TRUE(lost(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(9))));
  EXPECT_TRUE(lost(cv::Mat(1, 300, CV_8UC3, cv::Scalar::all(9))));
  EXPECT_TRUE(lost(wide));
  EXPECT_TRUE(lost(cv::Mat()));
  record("blank, saturated, random, single bright pixels, 1 x 1, 1 x 300, 16-bit, empty",
         "all contours lost, confidence 0",
         "low evidence");
}

TEST(HC38, AlphaAndOddStridesAreTheSamePicture) {
  const Clip clip = part_of(usual_performer(), 10, 8);
  const auto as_seen = [&](const PictureChange& change) {
    return track(changed(clip.frames, change)).sets;
  };
  const std::vector<ContourSet> plain = track(clip.frames).sets;
  const bool alpha = plain == as_seen([](size_t, const cv::Mat& picture) {
                       cv::Mat out;
                       cv::cvtColor(picture, out, cv::COLOR_BGR2BGRA);
                       return out;
                     });
  const bool stride = plain == as_seen([](size_t, const cv::Mat& picture) {
                        cv::Mat wide(picture.rows + 3, picture.cols + 7, CV_8UC3, cv::Scalar(5));
                        cv::Mat inner = wide(cv::Rect(2, 1, picture.cols, picture.rows));
                        picture.copyTo(inner);
                        return inner;
                      });
  EXPECT_TRUE(alpha);
  EXPECT_TRUE(stride);
  record("alpha channel; a window of a larger picture", "same bits", "same contours");
}

TEST(HC39, AStillPictureDoesNotCreep) {
  const int num_frames = long_tests() ? 1000 : 200;  // the first half to settle
  const Clip& clip = usual_performer();
  std::string measured;
  for (const size_t at : {size_t{0}, size_t{48}}) {
    Tracker tracker;
    ContourSet settled, last;
    double creep = 0.0;
    for (int i = 0; i < num_frames; ++i) {
      last = tracker.track(Frame{i, i / 25.0, clip.frames[at].image});
      if (i == num_frames / 2) settled = last;
    }
    std::string furthest;
    for (size_t f = 0; f < last.contours.size(); ++f) {
      for (size_t n = 0; n < last.contours[f].points_px.size(); ++n) {
        const double d = (last.contours[f].points_px[n] - settled.contours[f].points_px[n]).norm();
        if (d <= creep) continue;
        creep = d;
        furthest = last.contours[f].name;
      }
    }
    EXPECT_LT(creep, 0.05) << furthest;
    measured += (measured.empty() ? "" : "; ") + figure(creep) + " px (" + furthest + ")";
  }
  record("whole tracker, " + std::to_string(num_frames) +
             " times the same picture, at rest and smiling, second half",
         "the furthest node creeps by " + measured,
         "< 0.05 px");
}

TEST(HC41, ContoursKeepTheirOrder) {
  const Clip& clip = usual_performer();
  const Track& track = usual_track();
  double lips = 1e9, brows = 1e9, sides = 1e9, chin = 1e9, swap = -1e9;
  for (size_t i = 0; i < track.sets.size(); ++i) {
    const auto& c = [&](const char* name) { return *track.sets[i].visible(name); };
    const Contour &upper = c("upper_lip"), &lower = c("lower_lip");
    for (size_t n = 1; n + 1 < upper.points_px.size(); ++n) {
      lips = std::min(lips, (lower.points_px[n].y() - upper.points_px[n].y()) / clip.chart_px);
    }
    chin = std::min(chin, (middle_of(c("chin_boss")).y() - middle_of(lower).y()) / clip.chart_px);
    const double nose = middle_of(c("nose_tip")).y();
    for (const char* brow : {"brow_left", "brow_right"}) {
      brows = std::min(brows, (nose - middle_of(c(brow)).y()) / clip.chart_px);
      // The other edges near a brow lie 6 px and more from it: its lower edge, the crease of the
      // lid.
      swap = std::max(swap, distance(c(brow), *clip.truth[i].visible(brow), clip.chart_px));
    }
    sides = std::min({sides,
                      (middle_of(c("brow_left")).x() - middle_of(c("brow_right")).x()),
                      (middle_of(c("furrow_left")).x() - middle_of(c("furrow_right")).x())});
    // The other edges near the outer border of a lip: teeth, the line between the lips.
    for (const char* lip : {"upper_lip", "lower_lip"}) {
      swap = std::max(swap, distance(c(lip), *clip.truth[i].visible(lip), clip.chart_px));
    }
  }
  EXPECT_GT(lips, 0.0);
  EXPECT_GT(chin, 5.0);
  EXPECT_GT(brows, 30.0);
  EXPECT_GT(sides, 0.0);
  EXPECT_LT(swap, 4.0);
  record("raised brows, smile, frown, surprise with open mouth, speech: 150 frames",
         "lips at least " + figure(lips) + " px apart, chin " + figure(chin) +
             " px below; no brow or lip further than " + figure(swap) + " px from its own edge",
         "order kept; no swap to an edge nearby (6 px)");
}

struct Disturbance {
  const char* name;
  size_t first, count;
  PictureChange change;
};

TEST(HC43, ShortDisturbancesAreBridged) {
  const Clip& clip = usual_performer();
  const Track& usual = usual_track();
  const auto blink = [&](size_t i, const cv::Mat& picture) {
    cv::Mat out = picture.clone();
    // Skin over the eyes, at the height of the brows' distance to the nose.
    for (const char* name : {"brow_left", "brow_right"}) {
      const Point2 brow = middle_of(*clip.truth[i].visible(name));
      const cv::Point eye(static_cast<int>(brow.x()),
                          static_cast<int>(brow.y() + 21.0 * clip.chart_px));
      cv::ellipse(
          out,
          eye,
          cv::Size(static_cast<int>(14 * clip.chart_px), static_cast<int>(6 * clip.chart_px)),
          0,
          0,
          360,
          cv::mean(
              picture(cv::Rect(eye.x - 3, static_cast<int>(eye.y + 14 * clip.chart_px), 6, 6))),
          cv::FILLED,
          cv::LINE_AA);
    }
    return out;
  };
  const std::vector<Disturbance> all{
      {"blink, 4 frames", 40, 4, blink},
      {"motion blur of 13 px, 3 frames",
       40,
       3,
       [](size_t, const cv::Mat& p) { return motion_blurred(p, 13); }},
      {"exposure x 2, 10 frames", 45, 10, [](size_t, const cv::Mat& p) { return exposed(p, 2.0); }},
      {"exposure x 0.5, 10 frames",
       45,
       10,
       [](size_t, const cv::Mat& p) { return exposed(p, 0.5); }},
      {"compression to blocks (quality 8), 15 frames",
       40,
       15,
       [](size_t, const cv::Mat& p) { return jpeg(p, 8); }},
      {"the same picture 4 times, then on", 30, 4, [&](size_t, const cv::Mat&) {
         return clip.frames[29].image;
       }}};
  for (const Disturbance& d : all) {
    const size_t end = d.first + d.count;
    const std::vector<Frame> frames =
        changed(part_of(clip, 0, end + 20).frames, [&](size_t i, const cv::Mat& picture) {
          return i >= d.first && i < end ? d.change(i, picture) : picture;
        });
    const Track out = track(frames);
    const Departure during = departure(out.sets, usual.sets, clip.chart_px, d.first, end);
    const Departure after =
        departure(out.sets, usual.sets, clip.chart_px, end + kRecovery, end + 20);
    EXPECT_TRUE(during.worst < kStatedError_px || during.confidence < 0.7) << d.name;
    EXPECT_LT(after.worst, 0.5 * kStatedError_px) << d.name;
    EXPECT_EQ(after.lost, 0) << d.name;
    record(d.name,
           "off by at most " + figure(during.worst) + " px at " + figure(during.confidence) +
               " of the usual confidence; 5 frames later by " + figure(after.worst) + " px",
           "within 2 px or flagged; right again 5 frames later (1 px)");
  }
}

TEST(HC43, TheHeadMayMoveAFaceMayTurn) {
  const Clip& clip = usual_performer();
  const Track& usual = usual_track();
  const Point2 middle = middle_of(*clip.truth[0].visible("nose_tip"));
  struct Case {
    const char* name;
    std::function<Similarity(double)> motion;  // of the share done
  };
  const auto about = [&](double a, double b) {
    return Similarity{
        a, b, middle - Point2(a * middle.x() - b * middle.y(), b * middle.x() + a * middle.y())};
  };
  const std::vector<Case> cases{
      {"grows to twice its size within 25 frames", [&](double s) { return about(1.0 + s, 0.0); }},
      {"shrinks to 0.6 within 25 frames", [&](double s) { return about(1.0 - 0.4 * s, 0.0); }},
      {"rolls by 20 deg within 25 frames",
       [&](double s) { return about(std::cos(0.349 * s), std::sin(0.349 * s)); }},
      {"rolls by -20 deg within 25 frames",
       [&](double s) { return about(std::cos(0.349 * s), -std::sin(0.349 * s)); }}};
  for (const Case& c : cases) {
    const auto motion_at = [&](size_t i) {
      const double s = std::clamp((static_cast<double>(i) - 20.0) / 25.0, 0.0, 1.0);
      return c.motion(0.5 - 0.5 * std::cos(3.14159265 * s));
    };
    const std::vector<Frame> frames =
        changed(part_of(clip, 0, 75).frames,
                [&](size_t i, const cv::Mat& picture) { return moved(picture, motion_at(i)); });
    std::vector<ContourSet> back = track(frames).sets;
    for (size_t i = 0; i < back.size(); ++i) back[i] = moved(back[i], motion_at(i).inverse());
    const Departure on_the_way = departure(back, usual.sets, clip.chart_px, 20, 45);
    const Departure after = departure(back, usual.sets, clip.chart_px, 50, 75);
    EXPECT_LT(on_the_way.worst, kStatedError_px) << c.name;
    EXPECT_LT(after.worst, kStatedError_px) << c.name;
    EXPECT_EQ(on_the_way.lost + after.lost, 0) << c.name;
    record(std::string("the picture ") + c.name,
           "off by at most " + figure(on_the_way.worst) + " px on the way, " + figure(after.worst) +
               " px from 5 frames after (px of the first picture's chart)",
           "within 2 px");
  }
}

TEST(HC44, AHandBeforeTheMouthOrTheWholeFaceIsFlagged) {
  const Clip& clip = usual_performer();
  const Track& usual = usual_track();
  for (const size_t length : {10U, 20U, 30U}) {
    for (const bool whole : {false, true}) {
      const size_t first = 35;
      const size_t end = first + length;
      const cv::Size size = whole ? cv::Size(static_cast<int>(150 * clip.chart_px),
                                             static_cast<int>(210 * clip.chart_px))
                                  : cv::Size(static_cast<int>(80 * clip.chart_px),
                                             static_cast<int>(50 * clip.chart_px));
      const std::vector<Frame> frames =
          changed(part_of(clip, 0, end + 20).frames, [&](size_t i, const cv::Mat& picture) {
            if (i < first || i >= end) return picture;
            const ContourSet& truth = clip.truth[i];
            const Point2 at = whole ? middle_of(*truth.visible("nose_tip"))
                                    : Point2(0.5 * middle_of(*truth.visible("upper_lip")) +
                                             0.5 * middle_of(*truth.visible("lower_lip")));
            return with_hand(picture, at, size);
          });
      const Track out = track(frames);
      double worst_flag = 0.0, usual_flag = 0.0, after = 0.0;
      for (size_t i = first + 1; i < end; ++i) {
        for (const char* name : {"upper_lip", "lower_lip"}) {
          const Contour* lip = out.sets[i].visible(name);
          if (lip != nullptr) worst_flag = std::max(worst_flag, lip->confidence);
          usual_flag += usual.sets[i].visible(name)->confidence /
                        (2.0 * static_cast<double>(end - first - 1));
        }
      }
      const Departure later =
          departure(out.sets, usual.sets, clip.chart_px, end + kRecovery, end + 20);
      after = later.worst;
      const bool holds =
          worst_flag < 0.6 * usual_flag && after < kStatedError_px && later.lost == 0;
      record(std::string(whole ? "a hand before the whole face" : "a hand before the mouth") +
                 " for " + std::to_string(length) + " frames",
             "confidence of the lips at most " + figure(worst_flag) + " (usual " +
                 figure(usual_flag) + "); 5 frames later off by at most " + figure(after) +
                 " px, lost in " + std::to_string(later.lost) + " of 15 frames",
             "flagged; right again within 5 frames (2 px)",
             holds ? Outcome::kHolds : Outcome::kOpen);
    }
  }
}

// A fold from the wing of the nose to the corner of the mouth, painted into the face at rest.
cv::Mat with_furrows(const cv::Mat& picture, const ContourSet& truth, double depth) {
  cv::Mat dark(picture.size(), CV_32F, cv::Scalar(0.0));
  for (const char* name : {"furrow_left", "furrow_right"}) {
    std::vector<cv::Point> line;
    for (const Point2& p : truth.visible(name)->points_px) {
      line.emplace_back(static_cast<int>(std::lround(16.0 * p.x())),
                        static_cast<int>(std::lround(16.0 * p.y())));
    }
    cv::polylines(dark, line, false, cv::Scalar(1.0), 3, cv::LINE_8, 4);
  }
  cv::GaussianBlur(dark, dark, cv::Size(), 1.2);
  cv::Mat out;
  picture.convertTo(out, CV_32FC3);
  cv::Mat three;
  cv::merge(std::vector<cv::Mat>(3, depth * dark), three);
  out -= three;
  out.convertTo(out, CV_8UC3);
  return out;
}

TEST(HC57, AFurrowComesAndGoes) {
  const Clip& clip = usual_performer();
  const ContourSet& truth = clip.truth[0];
  Tracker tracker;
  double absent = 0.0, present = 0.0, gone = 0.0, creep = 0.0, off = 0.0;
  ContourSet before;
  for (int i = 0; i < 75; ++i) {
    // Absent for 25 frames, present for 25, absent again; it comes and goes within 3.
    const double shown = std::clamp(std::min((i - 25) / 3.0, (53 - i) / 3.0), 0.0, 1.0);
    const cv::Mat picture = with_furrows(
        noisy(clip.frames[0].image, 2.0, static_cast<std::uint64_t>(i)), truth, 60.0 * shown);
    const ContourSet set = tracker.track(Frame{i, i / 25.0, picture});
    if (i == 10) before = set;
    for (const char* name : {"furrow_left", "furrow_right"}) {
      const Contour* furrow = set.visible(name);
      ASSERT_NE(furrow, nullptr);
      const double c = 0.5 * furrow->confidence;
      if (i >= 10 && i < 25) {
        absent += c / 15.0;
        creep = std::max(creep, distance(*furrow, *before.visible(name), clip.chart_px));
      }
      if (i >= 33 && i < 50) {
        present += c / 17.0;
        off = std::max(off, distance(*furrow, *truth.visible(name), clip.chart_px));
      }
      if (i >= 60) gone += c / 15.0;
    }
  }
  const bool follows = present > absent + 0.1 && present > gone + 0.1;
  EXPECT_LT(creep, 1.0);
  EXPECT_LT(off, 4.0);
  record("a furrow painted into a still face, absent, present, absent for 25 frames each",
         "confidence " + figure(absent) + ", " + figure(present) + ", " + figure(gone) +
             "; while absent it creeps by " + figure(creep) +
             " px; 5 frames after it has come at most " + figure(off) + " px from it",
         "confidence follows visibility; coasts while absent; locks again within 5 frames",
         follows && off < kStatedError_px ? Outcome::kHolds : Outcome::kOpen);
}

TEST(HC61, LightChangesAreNoExpression) {
  const Clip& clip = usual_performer();
  const cv::Mat& still = clip.frames[0].image;
  struct Case {
    const char* name;
    std::function<cv::Mat(double)> light;  // of the share of 60 frames that has passed
  };
  const std::vector<Case> cases{
      {"ramp to half the light", [&](double s) { return exposed(still, 1.0 - 0.5 * s); }},
      {"ramp to 1.6 times the light", [&](double s) { return exposed(still, 1.0 + 0.6 * s); }},
      {"step to half the light", [&](double s) { return exposed(still, s < 0.5 ? 1.0 : 0.5); }},
      {"step to gamma 0.5", [&](double s) { return s < 0.5 ? still : with_gamma(still, 0.5); }},
      {"step to gamma 2", [&](double s) { return s < 0.5 ? still : with_gamma(still, 2.0); }}};
  for (const Case& c : cases) {
    Tracker tracker;
    ContourSet before;
    double drift = 0.0;
    std::string worst_name;
    double size_change = 0.0;
    for (int i = 0; i <= 70; ++i) {
      const double s = std::clamp((i - 10) / 60.0, 0.0, 1.0);
      const ContourSet set = tracker.track(Frame{i, i / 25.0, c.light(s)});
      if (i == 9) before = set;
      if (i < 10) continue;
      for (const Contour& contour : set.contours) {
        const Contour* then = before.visible(contour.name);
        ASSERT_TRUE(then != nullptr && !contour.lost()) << c.name << ": " << contour.name;
        const double d = distance(contour, *then, clip.chart_px);
        if (d > drift) worst_name = contour.name;
        drift = std::max(drift, d);
      }
      size_change = std::max(size_change, mean_distance(set, before, clip.chart_px));
    }
    EXPECT_LT(size_change, std::string(c.name).find("gamma") == std::string::npos ? 0.5 : 4.0)
        << c.name;
    record(std::string("still face, ") + c.name,
           "contours drift by at most " + figure(size_change) + " px on average, the worst (" +
               worst_name + ") by " + figure(drift),
           "< 0.5 px",
           drift < 0.5 ? Outcome::kHolds : Outcome::kOpen);
  }
}

TEST(HC62, ErrorGrowsSmoothlyWithNoiseAndBlocks) {
  const Clip& clip = usual_performer();
  struct Level {
    std::string name;
    PictureChange change;
  };
  const auto sweep = [&](const std::string& what, const std::vector<Level>& levels) {
    std::string measured;
    double before = 0.0;
    for (const Level& level : levels) {
      const Clip part = part_of(clip, 0, 60);
      const Track out = track(changed(part.frames, level.change));
      double error = 0.0;
      for (size_t i = 0; i < part.frames.size(); ++i) {
        error += mean_distance(out.sets[i], usual_track().sets[i], clip.chart_px) / 60.0;
      }
      EXPECT_LT(error, kStatedError_px) << level.name;
      EXPECT_GT(error, before - 0.15) << level.name;
      before = error;
      measured += (measured.empty() ? "" : "; ") + level.name + ": " + figure(error) + " px";
    }
    record(what, measured, "grows smoothly, within 2 px");
  };
  const auto noise = [](double sigma) {
    return [sigma](size_t i, const cv::Mat& p) { return noisy(p, sigma, i); };
  };
  sweep("noise of 5, 10, 20 grey levels; mean distance to the track of the clean clip, 60 frames",
        {{"5", noise(5.0)}, {"10", noise(10.0)}, {"20", noise(20.0)}});
  const auto blocks = [](int quality) {
    return [quality](size_t, const cv::Mat& p) { return jpeg(p, quality); };
  };
  sweep("JPEG of quality 40, 20, 10, 5; the same",
        {{"40", blocks(40)}, {"20", blocks(20)}, {"10", blocks(10)}, {"5", blocks(5)}});
}

TEST(HC63, ACutIsNeverContinued) {
  const Clip& one = usual_performer();
  const Clip other = part_of(performer(201, "mixed", 5.0, 12.0), 10, 30);
  std::vector<Frame> frames = part_of(one, 0, 20).frames;
  for (const Frame& frame : other.frames) frames.push_back(frame);
  const Track cut = track(frames);
  // Alone, the other clip starts afresh: so it must after the cut.
  const Track alone = track(other.frames);
  double off = 0.0;
  int lost = 0;
  for (size_t i = 0; i < other.frames.size(); ++i) {
    const double d = mean_distance(cut.sets[20 + i], alone.sets[i], other.chart_px);
    if (std::isfinite(d)) {
      off = std::max(off, d);
    } else {
      ++lost;
    }
  }
  EXPECT_EQ(off, 0.0);
  EXPECT_EQ(lost, 0);
  record("cut to another person in front of another wall",
         "started anew in the first frame after the cut: " + figure(off) +
             " px from a track of that clip alone",
         "flagged at that frame; restart or end");
}

TEST(HC63, BlackFramesEndTheTrackUntilTheFaceIsBack) {
  const Clip& clip = usual_performer();
  for (const size_t length : {1U, 3U, 12U}) {
    const std::vector<Frame> frames =
        changed(part_of(clip, 0, 50 + length).frames, [&](size_t i, const cv::Mat& p) {
          return i >= 30 && i < 30 + length ? cv::Mat(p.size(), p.type(), cv::Scalar::all(0)) : p;
        });
    const Track out = track(frames);
    double confidence = 0.0;
    for (size_t i = 30; i < 30 + length; ++i) {
      expect_well_formed(out.sets[i]);
      confidence = std::max(confidence, mean_confidence(out.sets[i]));
    }
    const Departure after =
        departure(out.sets, usual_track().sets, clip.chart_px, 31 + length, 50 + length);
    EXPECT_LT(confidence, 0.6 * mean_confidence(out.sets[29])) << length;
    EXPECT_EQ(after.lost, 0) << length;
    EXPECT_LT(after.worst, kStatedError_px) << length;
    record(std::to_string(length) + " black frames",
           "confidence falls from " + figure(mean_confidence(out.sets[29])) + " to at most " +
               figure(confidence) + ", in the last of them " +
               figure(mean_confidence(out.sets[29 + length])) +
               "; from the second frame after off by at most " + figure(after.worst) + " px",
           "flagged at that frame; never a false continuation");
  }
}

TEST(HC65, SmallPicturesAreTrackedOrLost) {
  const Clip clip = part_of(usual_performer(), 0, 40);
  for (const double scale : {0.5, 0.35, 0.25, 0.12, 0.03}) {
    const Track out = track(changed(clip.frames, [&](size_t, const cv::Mat& p) {
      cv::Mat small;
      cv::resize(p, small, cv::Size(), scale, scale, cv::INTER_AREA);
      return small;
    }));
    const Similarity larger{1.0 / scale, 0.0, Point2::Constant(0.5 / scale - 0.5)};
    std::vector<ContourSet> back;
    for (const ContourSet& set : out.sets) {
      expect_well_formed(set);
      back.push_back(moved(set, larger));
    }
    const Departure d = departure(back, usual_track().sets, clip.chart_px, 0, 40);
    const double eyes_px = 64.0 * clip.chart_px * scale;
    EXPECT_TRUE(d.lost == 40 || d.worst < 2.0 * kStatedError_px) << scale;
    record("eyes " + figure(eyes_px) + " px apart in a picture of " +
               std::to_string(static_cast<int>(360 * scale)) + " rows",
           d.lost == 40 ? "all lost"
                        : "off by " + figure(d.mean) + " px of the large picture, at most " +
                              figure(d.worst) + ", lost in " + std::to_string(d.lost) + " of 40",
           "tracked, or lost and said so");
  }
}

TEST(HC66, AFaceMayLeaveThePictureAndComeBack) {
  const Clip& clip = usual_performer();
  struct Way {
    const char* name;
    Point2 most_px;
  };
  for (const Way& way : {Way{"down, the mouth out of the picture", {0.0, 150.0}},
                         Way{"to the side, half the face out", {230.0, 0.0}},
                         Way{"to the side, all out", {420.0, 0.0}}}) {
    // Away in 20 frames, out for 15, back in 20.
    const auto shift_at = [&](size_t i) {
      const double t = static_cast<double>(i);
      const double s = std::clamp(std::min((t - 10.0) / 20.0, (65.0 - t) / 20.0), 0.0, 1.0);
      return Similarity{1.0, 0.0, (0.5 - 0.5 * std::cos(3.14159265 * s)) * way.most_px};
    };
    const std::vector<Frame> frames =
        changed(part_of(clip, 0, 95).frames, [&](size_t i, const cv::Mat& picture) {
          cv::Mat out;
          const Similarity s = shift_at(i);
          const cv::Matx23d matrix(1, 0, s.shift.x(), 0, 1, s.shift.y());
          cv::warpAffine(picture,
                         out,
                         matrix,
                         picture.size(),
                         cv::INTER_LINEAR,
                         cv::BORDER_CONSTANT,
                         cv::Scalar::all(60));
          return out;
        });
    const Track out = track(frames);
    std::vector<ContourSet> back;
    double outside = 0.0;
    for (size_t i = 0; i < out.sets.size(); ++i) {
      expect_well_formed(out.sets[i]);
      for (const Contour& contour : out.sets[i].contours) {
        if (contour.lost()) continue;
        const Point2 p = middle_of(contour);
        if (p.x() < 0 || p.y() < 0 || p.x() > 479 || p.y() > 359) {
          outside = std::max(outside, contour.confidence);
        }
      }
      back.push_back(moved(out.sets[i], shift_at(i).inverse()));
    }
    const Departure after = departure(back, usual_track().sets, clip.chart_px, 70, 95);
    EXPECT_EQ(outside, 0.0);
    const bool holds = after.worst < kStatedError_px && after.lost == 0;
    record(std::string("moves ") + way.name + ", and back",
           "contours outside the picture are lost; 5 frames after the return off by at most " +
               figure(after.worst) + " px, lost in " + std::to_string(after.lost) + " of 25",
           "no image force outside; flagged; recovers (2 px)",
           holds ? Outcome::kHolds : Outcome::kOpen);
  }
}

TEST(HC67, GivenPointsThatAreNotFiniteAreRefused) {
  const Clip& clip = usual_performer();
  ContourSet bad = clip.truth[0];
  bad.contours[2].points_px[1].x() = std::nan("");
  Tracker tracker;
  try {
    tracker.start_from(bad);
    tracker.track(clip.frames[0]);
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(bad.contours[2].name), std::string::npos);
  }
  record("a start from contours one of whose points is NaN",
         "refused, the contour named",
         "rejected at the stage where it appears",
         Outcome::kRefused);
}

}  // namespace
}  // namespace zygoma::hard
