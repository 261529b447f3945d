#include "src/pipeline/track_video.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>

#include "src/base/check.h"
#include "src/io/video_writer.h"
#include "src/pipeline/producer.h"
#include "tracker/picture.h"

namespace zygoma {
namespace {

constexpr size_t kFramesAhead = 4;  // decoded; a camera drops what comes faster than that is used
constexpr int kFramesToSpare = 5;   // that containers claim too many or decoders lose
constexpr int kRecordingQuality = 16;  // rate factor: tracking the recording is tracking the face

// 0: nobody knows.
int about_num_frames(const VideoInfo& info, const TrackLimits& limits) {
  if (limits.duration_s <= 0.0) return info.about_num_frames;
  const auto wanted =
      static_cast<int>(std::ceil(std::min(1e8, limits.duration_s * info.average_frames_per_s)));
  return info.about_num_frames > 0 ? std::min(info.about_num_frames, wanted) : wanted;
}

// What the landmarks of a frame say to the tracker that is about to see it.
void guide(const TrackGuidance& guidance, int frame, Tracker& tracker) {
  if (guidance.landmarks == nullptr) return;
  const auto seen = guidance.landmarks->seen.find(frame);
  if (seen == guidance.landmarks->seen.end()) return;
  const bool is_first = seen == guidance.landmarks->seen.begin() && !guidance.initial;
  if (is_first || (frame > 0 && !tracker.report().face_found)) tracker.start_from(seen->second);
  if (guidance.landmarks_are_prior) tracker.set_prior(seen->second);
}

// A file of landmarks that speaks of another number of frames was made from another video.
void require_length(const TrackGuidance& guidance, const std::string& what, int num_frames) {
  if (guidance.landmarks == nullptr || num_frames <= 0) return;
  const int difference = std::abs(guidance.landmarks->num_frames - num_frames);
  require(difference <= std::max(kFramesToSpare, num_frames / 50),
          guidance.landmarks->path + ": is of " + std::to_string(guidance.landmarks->num_frames) +
              " frames, " + what + " has " + std::to_string(num_frames) +
              ", expected landmarks of this video");
}

// One frame through the tracker; the record of it goes to the end of `result`.
void track_frame(const Frame& frame,
                 const TrackGuidance& guidance,
                 Tracker& tracker,
                 TrackedVideo& result) {
  guide(guidance, frame.index, tracker);
  result.contours.push_back(tracker.track(frame));
  if (tracker.report().face_found) ++result.frames_with_face;
  const Similarity* head = tracker.head();
  result.heads.push_back(head ? std::optional(*head) : std::nullopt);
}

void require_face(const TrackedVideo& result) {
  const std::string num_frames = std::to_string(result.contours.size());
  require(result.frames_with_face > 0 || result.stopped,
          result.info.path + ": no face found in " + num_frames +
              (result.contours.size() == 1 ? " frame" : " frames") +
              ", expected a frontal face at least 80 pixels wide, or contours of the first frame "
              "to start from");
}

}  // namespace

TrackedVideo track_video(const VideoSource& source,
                         const TrackGuidance& guidance,
                         const TrackerOptions& options,
                         StageObserver& observer,
                         const StopQuestion& stop,
                         const TrackLimits& limits) {
  options.check();
  std::atomic<bool> abandoned{false};  // tells a reader that waits for its camera
  VideoReader reader(source, [&] { return abandoned || (stop && stop()); });
  Tracker tracker(options);
  SecondLooks looks_left =
      source.is_camera || guidance.landmarks_are_prior ? SecondLooks::kNone : limits.second_looks;
  SecondLookOptions look_options;
  look_options.start_is_given = guidance.initial || guidance.landmarks != nullptr;
  SecondLook second_look(look_options);
  if (guidance.initial) tracker.start_from(*guidance.initial);

  TrackedVideo result;
  result.info = reader.info();
  result.source = source;
  const VideoInfo& info = result.info;
  require_length(guidance, source.path, info.about_num_frames);
  std::optional<VideoWriter> recording;
  if (!limits.recording.empty()) {
    const VideoWriterOptions encoding{"ultrafast", kRecordingQuality, 1};
    recording.emplace(
        limits.recording, info.width_px, info.height_px, info.average_frames_per_s, encoding);
    result.source = limits.recording;
  }
  observer.begin(source.is_camera ? "track (Ctrl-C ends it)" : "track",
                 about_num_frames(info, limits));
  const Stopwatch watch;
  bool limit_reached = false;
  {
    Producer<Frame> frames(kFramesAhead, [&]() -> std::optional<Frame> {
      Frame frame;  // a fresh picture each time: the one before may still be in use
      if (!reader.read_planes(frame)) return std::nullopt;
      return frame;
    });
    while (const std::optional<Frame> frame = frames.next()) {
      limit_reached = limits.duration_s > 0.0 && frame->time_s >= limits.duration_s;
      if (limit_reached) break;
      track_frame(*frame, guidance, tracker, result);
      if (looks_left != SecondLooks::kNone) {
        second_look.add(*frame);
        if (second_look.full()) {
          second_look.look(tracker, result.contours, result.heads);
          if (looks_left == SecondLooks::kStart) looks_left = SecondLooks::kNone;
        }
      }
      if (recording) recording->write(Picture(*frame).bgr(), frame->time_s);
      observer.update(static_cast<int>(result.contours.size()));
      result.stopped = stop && stop();
      if (result.stopped) break;
    }
    abandoned = true;
  }
  if (looks_left != SecondLooks::kNone) second_look.look(tracker, result.contours, result.heads);
  // A camera that was waited for when the stop came has no frame to show for it.
  if (source.is_camera && stop && stop()) result.stopped = true;
  if (recording) recording->finish();
  require_face(result);
  if (!result.stopped && !limit_reached) {
    require_length(guidance, source.path, static_cast<int>(result.contours.size()));
  }
  observer.end();
  result.lips = tracker.lips();
  result.mirror = tracker.mirror();
  result.figures = {"track", static_cast<int>(result.contours.size()), watch.elapsed_ms()};
  result.repaired_timestamps = reader.repaired_timestamps();
  result.time_from_container = reader.has_time_stamps();
  result.ended_early = !result.stopped && !limit_reached && reader.ended_early();
  return result;
}

}  // namespace zygoma
