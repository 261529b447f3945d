// The second look: what following a stretch backwards mends, and what it leaves alone.
#include <gtest/gtest.h>

#include <cmath>

#include "src/base/check.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/second_look.h"

namespace zygoma::hard {
namespace {

double mean_distance_of(const std::vector<ContourSet>& sets,
                        const Clip& clip,
                        size_t first,
                        size_t count) {
  double sum = 0.0;
  for (size_t i = first; i < first + count; ++i) {
    sum += mean_distance(sets[i], clip.truth[i], clip.chart_px) / static_cast<double>(count);
  }
  return sum;
}

TEST(SecondLook, MendsAStartOnBlockyFrames) {
  const Clip clip = part_of(usual_performer(), 0, 40);
  const std::vector<Frame> frames = changed(clip.frames, [](size_t i, const cv::Mat& picture) {
    return i < 6 ? jpeg(blurred(picture, 2.5), 5) : picture;
  });
  SecondLookOptions options;
  options.num_frames = 40;
  const double once = mean_distance_of(track(frames).sets, clip, 0, 10);
  const double twice =
      mean_distance_of(track_with_second_looks(frames, options).contours, clip, 0, 10);
  RecordProperty("once_px", std::to_string(once));
  RecordProperty("twice_px", std::to_string(twice));
  EXPECT_LT(twice, 0.8 * once);
}

TEST(SecondLook, FindsTheFaceInFramesBeforeItWasFoundAgain) {
  const Clip clip = part_of(usual_performer(), 0, 40);
  // A head that lies on its side and comes upright: no cascade finds it at first, but it can be
  // followed there.
  const Point2 middle(0.5 * clip.frames[0].image.cols, 0.5 * clip.frames[0].image.rows);
  const std::vector<Frame> frames = changed(clip.frames, [&](size_t i, const cv::Mat& picture) {
    const double angle = std::max(0.0, 0.8 - 0.05 * static_cast<double>(i));
    Similarity turn{std::cos(angle), std::sin(angle), Point2::Zero()};
    turn.shift = middle - turn.apply(middle);
    return angle > 0.0 ? moved(picture, turn) : picture;
  });
  const Track once = track(frames);
  SecondLookOptions options;
  options.num_frames = 40;
  const LookedAt twice = track_with_second_looks(frames, options);
  int lost_once = 0;
  int lost_twice = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    lost_once += once.face_found[i] ? 0 : 1;
    lost_twice += twice.heads[i] ? 0 : 1;
  }
  EXPECT_GT(lost_once, 2) << lost_twice;
  EXPECT_LT(lost_twice, lost_once);
}

TEST(SecondLook, LeavesTheLastFrameOfAStretchAndJoinsStretches) {
  const Clip clip = part_of(usual_performer(), 0, 60);
  SecondLookOptions options;
  options.num_frames = 20;
  const std::vector<ContourSet> once = track(clip.frames).sets;
  const std::vector<ContourSet> twice = track_with_second_looks(clip.frames, options).contours;
  for (const size_t last : {19, 39, 59}) EXPECT_EQ(twice[last], once[last]) << last;
  // No jump where stretches join: not more motion from frame to frame than without.
  for (const size_t i : {20, 40}) {
    const double step_once = mean_distance(once[i], once[i - 1], clip.chart_px);
    const double step_twice = mean_distance(twice[i], twice[i - 1], clip.chart_px);
    EXPECT_LT(step_twice, step_once + 0.25) << i;
  }
  EXPECT_EQ(track_with_second_looks(clip.frames, options).contours, twice) << "the same bits again";
}

TEST(SecondLook, AGivenStartIsKept) {
  const Clip clip = part_of(usual_performer(), 0, 30);
  SecondLookOptions options;
  options.num_frames = 30;
  options.start_is_given = true;
  const std::vector<ContourSet> once = track(clip.frames).sets;
  const std::vector<ContourSet> twice = track_with_second_looks(clip.frames, options).contours;
  const double apart = mean_distance(once[0], twice[0], clip.chart_px);
  SecondLookOptions free = options;
  free.start_is_given = false;
  const std::vector<ContourSet> moved = track_with_second_looks(clip.frames, free).contours;
  EXPECT_LE(apart, 0.2 * mean_distance(once[0], moved[0], clip.chart_px) + 1e-9);
}

TEST(SecondLook, KeepsWithinItsMemory) {
  SecondLookOptions options;
  options.num_frames = 1000;
  options.memory_bytes = 3 * 100 * 100 * 5;
  SecondLook look(options);
  int kept = 0;
  while (!look.full()) {
    look.add({kept, 0.04 * kept, cv::Mat(100, 100, CV_8UC3, cv::Scalar(80, 80, 80))});
    ++kept;
  }
  EXPECT_EQ(kept, 5);
}

TEST(SecondLook, RefusesOptionsOutsideTheirRange) {
  SecondLookOptions options;
  options.num_frames = 1;
  EXPECT_THROW(SecondLook{options}, InputError);
  options = {};
  options.tolerance_iod = 0.0;
  EXPECT_THROW(SecondLook{options}, InputError);
}

}  // namespace
}  // namespace zygoma::hard
