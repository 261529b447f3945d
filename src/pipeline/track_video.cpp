#include "src/pipeline/track_video.h"

#include "src/base/check.h"
#include "src/pipeline/producer.h"

namespace zygoma {

TrackedVideo track_video(const std::string& path,
                         const std::optional<ContourSet>& initial,
                         const TrackerOptions& options,
                         StageObserver& observer,
                         const StopQuestion& stop) {
  options.check();
  VideoReader reader(path);
  Tracker tracker(options);
  if (initial) tracker.start_from(*initial);

  TrackedVideo result;
  result.info = reader.info();
  observer.begin("track", result.info.about_num_frames);
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
      const Similarity* head = tracker.head();
      result.heads.push_back(head ? std::optional(*head) : std::nullopt);
      observer.update(static_cast<int>(result.contours.size()));
      if (stop && stop()) {
        result.stopped = true;
        break;
      }
    }
  }
  const std::string num_frames = std::to_string(result.contours.size());
  require(result.frames_with_face > 0 || result.stopped,
          path + ": no face found in " + num_frames +
              (result.contours.size() == 1 ? " frame" : " frames") +
              ", expected a frontal face at least 80 pixels wide, or contours of the first frame "
              "to start from");
  observer.end();
  result.lips = tracker.lips();
  result.figures = {"track", static_cast<int>(result.contours.size()), watch.elapsed_ms()};
  result.repaired_timestamps = reader.repaired_timestamps();
  result.time_from_container = reader.has_time_stamps();
  result.ended_early = !result.stopped && reader.ended_early();
  return result;
}

}  // namespace zygoma
