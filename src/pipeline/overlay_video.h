// The performer's video with its contours drawn in, beside close-ups and confidence
// (overlay_view.h).
#pragma once

#include <string>

#include "src/base/stop.h"
#include "src/pipeline/stage_figures.h"
#include "src/pipeline/stage_observer.h"
#include "src/pipeline/track_video.h"

namespace zygoma {

// A stop leaves a valid file with the frames done so far.
StageFigures write_overlay_video(const TrackedVideo& tracked,
                                 const std::string& output,
                                 StageObserver& observer,
                                 const StopQuestion& stop);

}  // namespace zygoma
