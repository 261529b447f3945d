// Hard cases of the tracker in time and symmetry: rates, order, mirror, kinds of pictures and
// files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/rotation_tag.h"
#include "tracker/feature_schema.h"

namespace zygoma::hard {
namespace {

constexpr double kStatedError_px = 2.0;  // chart px: 3 % of the eye distance

struct Difference {
  double mean = 0.0;
  double worst = 0.0;  // of a frame's mean over contours
  double worst_contour = 0.0;
  std::string contour;
  int lost = 0;
};

Difference difference(const std::vector<ContourSet>& a,
                      const std::vector<ContourSet>& b,
                      double chart_px) {
  Difference out;
  double seen = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double d = mean_distance(a[i], b[i], chart_px);
    if (!std::isfinite(d)) {
      ++out.lost;
      continue;
    }
    out.mean += d;
    seen += 1.0;
    out.worst = std::max(out.worst, d);
    for (const Contour& contour : a[i].contours) {
      const Contour* other = b[i].visible(contour.name);
      if (contour.lost() || other == nullptr) continue;
      const double one = distance(contour, *other, chart_px);
      if (one <= out.worst_contour) continue;
      out.worst_contour = one;
      out.contour = contour.name;
    }
  }
  out.mean /= std::max(1.0, seen);
  return out;
}

std::string text_of(const Difference& d) {
  return figure(d.mean) + " px on average, a frame's mean by at most " + figure(d.worst) +
         ", one contour (" + d.contour + ") by " + figure(d.worst_contour);
}

std::vector<ContourSet> every(const std::vector<ContourSet>& sets, size_t step) {
  std::vector<ContourSet> out;
  for (size_t i = 0; i < sets.size(); i += step) out.push_back(sets[i]);
  return out;
}

TEST(HC45, RateDuplicatesAndJitterDoNotChangeTheTrajectory) {
  const Clip& clip = performer(1, "smile", 1.2, 60.0);
  const std::vector<ContourSet> fast = track(clip.frames).sets;
  std::vector<Frame> slow, twice, jittered = clip.frames;
  for (size_t i = 0; i < clip.frames.size(); ++i) {
    if (i % 6 == 0) slow.push_back(clip.frames[i]);
    twice.push_back(clip.frames[i]);
    twice.push_back(clip.frames[i]);
    jittered[i].time_s += 0.004 * std::sin(7.3 * static_cast<double>(i));
  }
  const Difference at_10 = difference(track(slow).sets, every(fast, 6), clip.chart_px);
  EXPECT_LT(at_10.worst, kStatedError_px);
  EXPECT_EQ(at_10.lost, 0);
  record("a smile at 10 and at 60 frames per second",
         "differ by " + text_of(at_10),
         "same trajectory (2 px)");
  const Difference doubled = difference(every(track(twice).sets, 2), fast, clip.chart_px);
  EXPECT_LT(doubled.worst, 0.5 * kStatedError_px);
  record("the same, every frame twice", "differ by " + text_of(doubled), "same trajectory (1 px)");
  std::vector<ContourSet> wobbling = track(jittered).sets;
  for (size_t i = 0; i < wobbling.size(); ++i) wobbling[i].time_s = fast[i].time_s;
  EXPECT_EQ(wobbling, fast);
  record("time stamps that jitter by 4 ms", "same bits but for the stamps", "same trajectory");
}

TEST(HC64, DroppedFramesKeepTheTrajectory) {
  const Clip& clip = usual_performer();
  std::vector<Frame> left;
  std::vector<ContourSet> expected;
  cv::RNG random(12);
  for (size_t i = 0; i < clip.frames.size(); ++i) {
    // A third of the frames goes, up to four in a row.
    if (i > 0 && (random.uniform(0, 4) == 0 || (i % 40 >= 36))) continue;
    left.push_back(clip.frames[i]);
    expected.push_back(usual_track().sets[i]);
  }
  const Track out = track(left);
  for (size_t i = 0; i < left.size(); ++i) EXPECT_EQ(out.sets[i].time_s, left[i].time_s);
  const Difference d = difference(out.sets, expected, clip.chart_px);
  EXPECT_LT(d.worst, kStatedError_px);
  EXPECT_EQ(d.lost, 0);
  record("a third of the frames dropped, up to four in a row",
         "stamps kept; differ by " + text_of(d),
         "times as in the container; trajectory unchanged (2 px)");
}

TEST(HC69, OneAndTwoThreadsGiveTheSameBits) {
  const Clip clip = part_of(usual_performer(), 0, 60);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const std::vector<ContourSet> one = track(clip.frames).sets;
  cv::setNumThreads(2);
  const std::vector<ContourSet> two = track(clip.frames).sets;
  cv::setNumThreads(threads);
  EXPECT_EQ(one, two);
  record("60 frames with one and with two threads", "same bits", "same bits");
}

TEST(HC70, BackwardsTheContoursAreTheSame) {
  const Clip& clip = usual_performer();
  std::vector<Frame> frames(clip.frames.rbegin(), clip.frames.rend());
  for (size_t i = 0; i < frames.size(); ++i) frames[i].time_s = clip.frames[i].time_s;
  std::vector<ContourSet> back = track(frames).sets;
  std::reverse(back.begin(), back.end());
  const Difference d = difference(back, usual_track().sets, clip.chart_px);
  EXPECT_LT(d.worst, kStatedError_px);
  EXPECT_EQ(d.lost, 0);
  record("150 frames backwards",
         "differ by " + text_of(d),
         "same contours per frame within the stated error (2 px)");
}

TEST(HC71, AnUprightPortraitComesOutOfARotatedFile) {
  const Clip clip = part_of(usual_performer(), 0, 25);
  const ScratchFolder folder;
  const std::string upright = folder / "upright.mp4", turned = folder / "turned.mp4";
  const cv::Size size = clip.frames[0].image.size();
  // Good enough that the two encodings differ little.
  VideoWriter plain(upright, size.width, size.height, 25.0, {"ultrafast", 8, 1});
  VideoWriter portrait(turned, size.height, size.width, 25.0, {"ultrafast", 8, 1});
  for (const Frame& frame : clip.frames) {
    cv::Mat lying;
    cv::rotate(frame.image, lying, cv::ROTATE_90_COUNTERCLOCKWISE);
    plain.write(frame.image, frame.time_s);
    portrait.write(lying, frame.time_s);
  }
  plain.finish();
  portrait.finish();
  tag_as_rotated(turned);
  const auto read = [](const std::string& path) {
    VideoReader reader(path);
    std::vector<Frame> frames;
    for (Frame frame; reader.read(frame);) {
      frames.push_back(frame);
      frames.back().image = frame.image.clone();
    }
    return track(frames).sets;
  };
  const std::vector<ContourSet> a = read(turned), b = read(upright);
  ASSERT_EQ(a.size(), clip.frames.size());
  ASSERT_EQ(b.size(), clip.frames.size());
  const Difference d = difference(a, b, clip.chart_px);
  EXPECT_LT(d.worst, 1.0);
  EXPECT_EQ(d.lost, 0);
  record("H.264 of a picture lying on its side, tagged to be turned, against the upright one",
         "differ by " + text_of(d),
         "decoded upright; contours and sides correct");
}

TEST(HC72, OneFrameIsARowAndNoneIsAnError) {
  const Clip& clip = usual_performer();
  const ScratchFolder folder;
  const std::string path = folder / "one.mp4";
  const cv::Size size = clip.frames[0].image.size();
  VideoWriter writer(path, size.width, size.height, 25.0, {"ultrafast", 10, 1});
  writer.write(clip.frames[0].image, 0.0);
  writer.finish();
  VideoReader reader(path);
  Frame frame;
  Tracker tracker;
  int rows = 0;
  for (; reader.read(frame); ++rows) tracker.track(frame);
  EXPECT_EQ(rows, 1);
  EXPECT_TRUE(tracker.report().face_found);
  const std::string empty = folder / "empty.mp4";
  std::ofstream(empty, std::ios::binary).put(' ');
  EXPECT_THROW(VideoReader{empty}, InputError);
  record("a clip of one frame; a file without pictures",
         "one set of contours; refused in one line that names the file",
         "one result row; a one-line error",
         Outcome::kRefused);
}

TEST(HC73, GreyDeepAndTransparentPictures) {
  const Clip clip = part_of(usual_performer(), 0, 75);
  const std::vector<ContourSet> usual(usual_track().sets.begin(), usual_track().sets.begin() + 75);
  const auto against_usual = [&](const PictureChange& change) {
    return difference(track(changed(clip.frames, change)).sets, usual, clip.chart_px);
  };
  const Difference alpha = against_usual([](size_t, const cv::Mat& p) {
    cv::Mat out;
    cv::cvtColor(p, out, cv::COLOR_BGR2BGRA);
    return out;
  });
  EXPECT_EQ(alpha.worst, 0.0);
  record("with an alpha channel", "same contours", "< 0.1 px");
  // The decoder hands out 8 bits; what ten bits change is the rounding.
  const Difference deep =
      against_usual([](size_t i, const cv::Mat& p) { return noisy(p, 0.4, i); });
  EXPECT_LT(deep.mean, 0.25 * kStatedError_px);
  record("ten bits rounded to eight another way (noise of 0.4 grey levels)",
         "differ by " + text_of(deep),
         "< 0.1 px",
         deep.worst < 0.1 ? Outcome::kHolds : Outcome::kOpen);
  const PictureChange grey = [](size_t, const cv::Mat& p) {
    cv::Mat out;
    cv::cvtColor(p, out, cv::COLOR_BGR2GRAY);
    return out;
  };
  const PictureChange grey_bgr = [&](size_t i, const cv::Mat& p) {
    cv::Mat out;
    cv::cvtColor(grey(i, p), out, cv::COLOR_GRAY2BGR);
    return out;
  };
  EXPECT_EQ(track(changed(clip.frames, grey)).sets, track(changed(clip.frames, grey_bgr)).sets);
  const Difference d = against_usual(grey);
  EXPECT_LT(d.worst, 2.0 * kStatedError_px);
  record("grey: the lips have lost their colour",
         "one and three channels same bits; against colour " + text_of(d),
         "< 0.1 px",
         d.worst < 0.1 ? Outcome::kHolds : Outcome::kOpen);
}

}  // namespace
}  // namespace zygoma::hard
