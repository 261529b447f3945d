// First stage: pictures in, the contours of every frame out. The same code follows a file and a
// camera, of which it takes no second look.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/base/stop.h"
#include "src/io/landmarks_file.h"
#include "src/io/video_reader.h"
#include "src/pipeline/stage_figures.h"
#include "src/pipeline/stage_observer.h"
#include "tracker/second_look.h"
#include "tracker/tracker.h"

namespace zygoma {

// What is known of the face from elsewhere.
struct TrackGuidance {
  std::optional<ContourSet> initial;  // replaces the automatic start
  // Replaces it too, in the first frame that has landmarks and whenever the face is lost.
  const LandmarkTrack* landmarks = nullptr;
  bool landmarks_are_prior = false;  // contours are drawn to them in every frame
};

// Which stretches of the clip are followed once more, backwards (tracker/second_look.h). None:
// what is said of a frame depends on earlier frames only, as with a camera.
enum class SecondLooks { kNone, kStart, kAll };

struct TrackLimits {
  double duration_s = 0.0;  // of what is tracked, by the time stamps; 0: to the end
  // A video of the pictures as they were tracked, for sources that cannot be read again; empty:
  // none. It is complete even when no face was found.
  std::string recording;
  SecondLooks second_looks = SecondLooks::kStart;
};

struct TrackedVideo {
  VideoInfo info;
  VideoSource source;  // of the same pictures once more: what was read, or the recording
  std::vector<ContourSet> contours;              // one per decoded frame
  std::vector<std::optional<Similarity>> heads;  // image from chart; none where there is no face
  LipMap lips;                                   // of this face
  Mirror mirror;                                 // which way round the pictures were looked at
  std::vector<int> repaired_timestamps;
  bool time_from_container = true;  // false: the file has no time stamps
  bool ended_early = false;         // the file holds fewer pictures than it claims
  bool stopped = false;
  int frames_with_face = 0;
  int contours_corrected = 0;  // contours, frame by frame, that corrections changed
  StageFigures figures;
};

// Decoding runs beside tracking. Throws InputError when the source cannot be read and when no
// picture of it shows a face.
TrackedVideo track_video(const VideoSource& source,
                         const TrackGuidance& guidance,
                         const TrackerOptions& options,
                         StageObserver& observer,
                         const StopQuestion& stop,
                         const TrackLimits& limits = {});

}  // namespace zygoma
