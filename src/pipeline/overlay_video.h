// The performer's video with its contours drawn in, at its own size.
#pragma once

#include <string>
#include <vector>

#include "src/base/stop.h"
#include "src/io/video_source.h"
#include "src/pipeline/stage_figures.h"
#include "src/pipeline/stage_observer.h"
#include "tracker/contour_set.h"

namespace zygoma {

StageFigures write_overlay_video(const VideoSource& source,
                                 const std::vector<ContourSet>& contours,
                                 const std::string& output,
                                 StageObserver& observer,
                                 const StopQuestion& stop);

}  // namespace zygoma
