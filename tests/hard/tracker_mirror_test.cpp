// Hard cases of the tracker in the mirror: left and right swap, and nothing else changes, to the
// bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "src/io/video_reader.h"
#include "src/pipeline/correct_track.h"
#include "src/pipeline/track_video.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/shared_folder.h"
#include "tests/support/silent_observer.h"
#include "tracker/face_chart.h"

namespace zygoma::hard {
namespace {

cv::Mat mirrored(const cv::Mat& picture) {
  cv::Mat out;
  cv::flip(picture, out, 1);
  return out;
}

std::vector<Frame> mirrored(const std::vector<Frame>& frames) {
  return changed(frames, [](size_t, const cv::Mat& picture) { return mirrored(picture); });
}

std::string other_side(std::string name) {
  for (const auto& [end, other] : {std::pair("_left", "_right"), std::pair("_right", "_left")}) {
    if (name.ends_with(end)) return name.replace(name.rfind(end), std::string::npos, other);
  }
  return name;
}

// Sides swapped and x turned about the middle of a picture that wide.
ContourSet mirrored(const ContourSet& set, int width) {
  ContourSet out = set;
  for (Contour& contour : out.contours) {
    const std::string from = other_side(contour.name);
    for (const Contour& other : set.contours) {
      if (other.name != from) continue;
      contour.points_px = other.points_px;
      contour.confidence = other.confidence;
      contour.locked = other.locked;
    }
    for (Point2& p : contour.points_px) p.x() = width - 1.0 - p.x();
    // One that crosses the middle runs from the subject's right to left: it would now run back.
    if (from == contour.name) std::reverse(contour.points_px.begin(), contour.points_px.end());
  }
  return out;
}

// Where the chart's points x and 192 - x lie must be mirror images; the rest follows.
void expect_mirrored(const std::optional<Similarity>& head,
                     const std::optional<Similarity>& in_mirror,
                     int width) {
  ASSERT_EQ(head.has_value(), in_mirror.has_value());
  if (!head) return;
  EXPECT_EQ(head->a, in_mirror->a);
  EXPECT_EQ(head->b, -in_mirror->b);
  const Point2 p = head->apply(Point2(40.0, 100.0));
  const Point2 q = in_mirror->apply(Point2(kChartWidth - 1.0 - 40.0, 100.0));
  EXPECT_NEAR(p.x(), width - 1.0 - q.x(), 1e-9);
  EXPECT_NEAR(p.y(), q.y(), 1e-9);
}

void expect_mirrored(const std::vector<ContourSet>& sets,
                     const std::vector<ContourSet>& in_mirror,
                     int width) {
  ASSERT_EQ(sets.size(), in_mirror.size());
  for (size_t i = 0; i < sets.size(); ++i) {
    ASSERT_EQ(sets[i], mirrored(in_mirror[i], width)) << "frame " << i;
    ASSERT_EQ(mirrored(sets[i], width), in_mirror[i]) << "frame " << i;
  }
}

int num_found(const LookedAt& track) {
  return static_cast<int>(std::count_if(
      track.heads.begin(), track.heads.end(), [](const auto& head) { return head.has_value(); }));
}

// Follows the frames and their mirror image, forwards and backwards; returns in how many a face was
// found.
int expect_swapped_sides(const std::vector<Frame>& frames) {
  const int width = frames[0].image.cols;
  const LookedAt track = track_with_second_looks(frames, {});
  const LookedAt in_mirror = track_with_second_looks(mirrored(frames), {});
  expect_mirrored(track.contours, in_mirror.contours, width);
  for (size_t i = 0; i < frames.size(); ++i) {
    expect_mirrored(track.heads[i], in_mirror.heads[i], width);
  }
  return num_found(track);
}

TEST(HC69, AMirroredClipSwapsTheSides) {
  const std::vector<Frame>& frames = usual_performer().frames;
  EXPECT_EQ(expect_swapped_sides(frames), static_cast<int>(frames.size()));
  record("150 frames mirrored, followed forwards and backwards",
         HasFailure() ? "not the same bits" : "same bits",
         "sides swap exactly");
}

TEST(HC69, AMirroredClipOfOddWidthSwapsTheSides) {
  const Clip clip = part_of(usual_performer(), 20, 40);
  for (const bool grey : {false, true}) {
    std::vector<Frame> frames = changed(clip.frames, [&](size_t, const cv::Mat& picture) {
      cv::Mat out = picture(cv::Rect(0, 0, picture.cols - 1, picture.rows)).clone();
      if (grey) cv::cvtColor(out, out, cv::COLOR_BGR2GRAY);
      return out;
    });
    // Two black pictures, which say nothing of which way round they are, and a cut.
    frames[0].image.setTo(0);
    frames[1].image.setTo(0);
    for (size_t i = 20; i < 24; ++i) {
      frames[i].image.setTo(cv::Scalar::all(90));
      frames[i].image.colRange(0, 100).setTo(cv::Scalar::all(static_cast<double>(30 + i)));
    }
    EXPECT_GT(expect_swapped_sides(frames), grey ? 0 : 20);
  }
}

TEST(HC69, AMirroredRealClipSwapsTheSides) {
  for (const char* name : {"smile.mp4", "webcam_man.mp4"}) {
    const std::string path = shared_folder() + "/video/" + name;
    if (!std::filesystem::exists(path)) {
      GTEST_SKIP() << path << " is not there; ZYGOMA_SHARED names the folder";
    }
    VideoReader reader(path);
    std::vector<Frame> frames;
    Frame frame;
    while (frames.size() < 75 && reader.read(frame)) {
      frames.push_back({frame.index, frame.time_s, frame.image.clone()});
    }
    EXPECT_EQ(expect_swapped_sides(frames), static_cast<int>(frames.size())) << name;
  }
}

TEST(HC69, GuidanceIsMirroredToo) {
  const Clip clip = part_of(usual_performer(), 0, 12);
  const int width = clip.frames[0].image.cols;
  const std::vector<Frame> turned = mirrored(clip.frames);
  Tracker one, other;
  one.start_from(clip.truth[0]);
  other.start_from(mirrored(clip.truth[0], width));
  for (size_t i = 0; i < clip.frames.size(); ++i) {
    if (i > 3) {
      one.set_prior(clip.truth[i]);
      other.set_prior(mirrored(clip.truth[i], width));
    }
    const ContourSet set = one.track(clip.frames[i]);
    EXPECT_EQ(set, mirrored(other.track(turned[i]), width)) << i;
    for (size_t f = 0; f < set.contours.size(); ++f) {
      const std::string twin = other_side(set.contours[f].name);
      for (size_t g = 0; g < set.contours.size(); ++g) {
        if (set.contours[g].name != twin) continue;
        EXPECT_EQ(one.report().terms[f], other.report().terms[g]) << twin;
      }
    }
  }
}

// Landmarks as another tracker might give them; which is whose twin in the mirror.
Landmarks some_landmarks(double shift_px) {
  Landmarks landmarks;
  const auto place = [&](size_t i, double x, double y) {
    landmarks[i] = Point2(240.0 + shift_px + 80.0 * x, 200.0 + 0.5 * shift_px + 80.0 * y);
  };
  for (size_t i = 0; i < 17; ++i) {
    const double t = (static_cast<double>(i) - 8.0) / 8.0;
    place(i, 1.1 * t, 1.9 - 1.6 * t * t);
  }
  for (size_t i = 0; i < 5; ++i) {
    const double t = static_cast<double>(i) / 4.0;
    place(17 + i, -0.9 + 0.7 * t, -0.4 - 0.1 * t * (1.0 - t));
    place(26 - i, 0.9 - 0.7 * t, -0.4 - 0.1 * t * (1.0 - t));
    place(31 + i, -0.2 + 0.4 * t, 0.75);
  }
  for (size_t i = 27; i < 31; ++i) place(i, 0.0, 0.15 * static_cast<double>(i - 27));
  for (size_t i = 0; i < 4; ++i) {
    const double t = static_cast<double>(i) / 3.0;
    place(36 + i, -0.7 + 0.43 * t, 0.02 - 0.3 * t * (1.0 - t));
    place(45 - i, 0.7 - 0.43 * t, 0.02 - 0.3 * t * (1.0 - t));
  }
  for (size_t i = 0; i < 2; ++i) {
    const double t = static_cast<double>(i);
    place(40 + i, -0.42 - 0.14 * t, 0.06);
    place(47 - i, 0.42 + 0.14 * t, 0.06);
  }
  for (size_t i = 0; i < 7; ++i) {
    const double t = static_cast<double>(i) / 3.0 - 1.0;
    place(48 + i, 0.38 * t, 1.15 - 0.12 * (1.0 - t * t));
  }
  for (size_t i = 0; i < 5; ++i) {
    const double t = (static_cast<double>(i) - 2.0) / 3.0;
    place(59 - i, 0.38 * t, 1.15 + 0.17 * (1.0 - t * t));
    place(60 + i, 0.5 * t, 1.14);
  }
  for (size_t i = 0; i < 3; ++i) place(67 - i, 0.15 * (static_cast<double>(i) - 1.0), 1.17);
  return landmarks;
}

Landmarks mirrored(const Landmarks& landmarks, int width) {
  constexpr std::array<std::array<size_t, 2>, 29> kTwins{
      {{0, 16},  {1, 15},  {2, 14},  {3, 13},  {4, 12},  {5, 11},  {6, 10},  {7, 9},
       {17, 26}, {18, 25}, {19, 24}, {20, 23}, {21, 22}, {31, 35}, {32, 34}, {36, 45},
       {37, 44}, {38, 43}, {39, 42}, {40, 47}, {41, 46}, {48, 54}, {49, 53}, {50, 52},
       {55, 59}, {56, 58}, {60, 64}, {61, 63}, {65, 67}}};
  Landmarks out = landmarks;
  for (const auto& [a, b] : kTwins) std::swap(out[a], out[b]);
  for (Point2& p : out) p.x() = width - 1.0 - p.x();
  return out;
}

TEST(HC69, LandmarksAreMirroredToo) {
  const Clip clip = part_of(usual_performer(), 0, 12);
  const int width = clip.frames[0].image.cols;
  const std::vector<Frame> turned = mirrored(clip.frames);
  Tracker one, other;
  for (size_t i = 0; i < clip.frames.size(); ++i) {
    const Landmarks landmarks = some_landmarks(0.8125 * static_cast<double>(i));
    if (i == 0) one.start_from(landmarks);
    if (i == 0) other.start_from(mirrored(landmarks, width));
    if (i > 0) one.set_prior(landmarks);
    if (i > 0) other.set_prior(mirrored(landmarks, width));
    const ContourSet set = one.track(clip.frames[i]);
    EXPECT_NE(set.visible("upper_lip"), nullptr);
    EXPECT_EQ(set, mirrored(other.track(turned[i]), width)) << i;
  }
}

// Numbered pictures on disk through the whole first stage, with a pull at a brow and one at the
// mouth.
TEST(HC69, AMirroredRunWithCorrectionsSwapsTheSides) {
  const Clip clip = part_of(usual_performer(), 0, 20);
  const int width = clip.frames[0].image.cols;
  const ScratchFolder folder;
  std::array<TrackedVideo, 2> tracked;
  SilentObserver silent;
  for (const bool turned : {false, true}) {
    const std::string name = turned ? "turned_" : "plain_";
    for (const Frame& frame : clip.frames) {
      cv::imwrite(folder / (name + std::to_string(frame.index) + ".png"),
                  turned ? mirrored(frame.image) : frame.image);
    }
    TrackedVideo& track = tracked[turned ? 1 : 0];
    track = track_video(folder / (name + "%d.png"), {}, {}, silent, {});
    std::vector<Correction> pulls(2);
    pulls[0].contour = turned ? "brow_left" : "brow_right";
    pulls[1].contour = "upper_lip";
    for (size_t k = 0; k < pulls.size(); ++k) {
      const size_t node = k == 0 ? 4 : turned ? 10 : 2;
      for (const Contour& contour : track.contours[8].contours) {
        if (contour.name == pulls[k].contour) pulls[k].at_px = contour.points_px[node];
      }
      pulls[k].id = static_cast<int>(k);
      pulls[k].frame = 8;
      pulls[k].along = static_cast<double>(node) / (k == 0 ? 8.0 : 12.0);
      pulls[k].at_px.y() -= 6.0;
    }
    correct_track(pulls, track, silent, {});
    EXPECT_GT(track.contours_corrected, 2);
  }
  EXPECT_EQ(tracked[0].contours_corrected, tracked[1].contours_corrected);
  expect_mirrored(tracked[0].contours, tracked[1].contours, width);
}

}  // namespace
}  // namespace zygoma::hard
