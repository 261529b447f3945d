// First stage: a video file in, the contours of every frame out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/base/stop.h"
#include "src/io/video_reader.h"
#include "src/pipeline/stage_figures.h"
#include "src/pipeline/stage_observer.h"
#include "tracker/tracker.h"

namespace zygoma {

struct TrackedVideo {
  VideoInfo info;
  std::vector<ContourSet> contours;              // one per decoded frame
  std::vector<std::optional<Similarity>> heads;  // image from chart; none where there is no face
  LipMap lips;                                   // of this face
  std::vector<int> repaired_timestamps;
  bool time_from_container = true;  // false: the file has no time stamps
  bool ended_early = false;         // the file holds fewer pictures than it claims
  bool stopped = false;
  int frames_with_face = 0;
  int contours_corrected = 0;  // contours, frame by frame, that corrections changed
  StageFigures figures;
};

// `initial` replaces the automatic start. Decoding runs beside tracking. Throws InputError when the
// file is no video and when no picture of it shows a face.
TrackedVideo track_video(const std::string& path,
                         const std::optional<ContourSet>& initial,
                         const TrackerOptions& options,
                         StageObserver& observer,
                         const StopQuestion& stop);

}  // namespace zygoma
