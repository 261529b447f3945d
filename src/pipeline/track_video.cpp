#include "src/pipeline/track_video.h"

#include "src/pipeline/producer.h"

namespace zygoma {

TrackedVideo track_video(const std::string& path,
                         const std::optional<ContourSet>& initial,
                         const TrackerOptions& options,
                         Progress& progress,
                         const StopQuestion& stop) {
  options.check();
  VideoReader reader(path);
  Tracker tracker(options);
  if (initial) tracker.start_from(*initial);

  TrackedVideo result;
  result.info = reader.info();
  progress.begin("track", result.info.about_num_frames);
  const Stopwatch watch;
  {
    Producer<Frame> frames(4, [&reader]() -> std::optional<Frame> {
      Frame frame;  // a fresh picture each time: the one before may still be in use
      if (!reader.read(frame)) return std::nullopt;
      return frame;
    });
    while (const std::optional<Frame> frame = frames.next()) {
      result.contours.push_back(tracker.track(*frame));
      if (tracker.report().face_found) ++result.frames_with_face;
      progress.frame_done();
      if (stop && stop()) {
        result.stopped = true;
        break;
      }
    }
  }
  progress.end();
  result.figures = {"track", static_cast<int>(result.contours.size()), watch.elapsed_ms()};
  result.repaired_timestamps = reader.repaired_timestamps();
  result.ended_early = !result.stopped && reader.ended_early();
  return result;
}

}  // namespace zygoma
