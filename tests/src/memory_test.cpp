// A long clip takes no more memory than a short one, but for its result: the contours of every
// frame are kept, and nothing else that grows.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdlib>

#include "src/io/video_writer.h"
#include "src/pipeline/track_video.h"
#include "src/synthetic/performer.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/silent_observer.h"

namespace zygoma {
namespace {

// A performer's frames, shown forwards and backwards for as long as is wanted.
std::string write_long_clip(const std::string& path, int num_frames) {
  PerformerOptions options;
  options.schedule = "smile";
  options.duration_s = 1.0;
  options.width_px = 320;
  options.height_px = 240;
  options.num_surface_vertices = 300;
  Performer performer(options);
  std::vector<cv::Mat> pictures;
  Frame frame;
  Contractions contractions;
  ContourSet contours;
  while (performer.next(frame, contractions, contours)) pictures.push_back(frame.image.clone());
  VideoWriter writer(path, options.width_px, options.height_px, 30.0, {"ultrafast", 23, 1});
  const int period = 2 * static_cast<int>(pictures.size()) - 2;
  for (int i = 0; i < num_frames; ++i) {
    const int phase = i % period;
    writer.write(pictures[std::min(phase, period - phase)], i / 30.0);
  }
  writer.finish();
  return path;
}

double bytes_in_use() {
  const auto heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

TEST(Memory, DoesNotGrowWithTheLengthOfTheClip) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has a heap of its own";
#endif
  const bool is_long = std::getenv("ZYGOMA_LONG_TESTS") != nullptr;
  const int few = is_long ? 300 : 150;
  const int many = is_long ? 3000 : 600;
  const ScratchFolder folder;
  const std::string clip = write_long_clip(folder / "clip.mp4", many);
  SilentObserver silent;
  // The first run loads what stays: cascades, threads, tables.
  track_video(clip, {}, {}, silent, {}, TrackLimits{0.5, {}});
  const auto bytes_after = [&](int num_frames) {
    const double before = bytes_in_use();
    const TrackLimits limits{(num_frames - 0.5) / 30.0, {}};
    const TrackedVideo tracked = track_video(clip, {}, {}, silent, {}, limits);
    EXPECT_EQ(static_cast<int>(tracked.contours.size()), num_frames);
    EXPECT_EQ(tracked.frames_with_face, num_frames);
    return bytes_in_use() - before;
  };
  const double grown = bytes_after(many) - bytes_after(few);
  const double per_frame = grown / (many - few);
  RecordProperty("bytes_per_frame", std::to_string(per_frame));
  // Some 100 nodes of 16 bytes, names and confidences, in blocks; vectors that double.
  EXPECT_LT(per_frame, 6000.0);
  const double before = bytes_in_use();
  bytes_after(few);
  EXPECT_LT(bytes_in_use() - before, 50000.0) << "left behind by a run";
}

}  // namespace
}  // namespace zygoma
