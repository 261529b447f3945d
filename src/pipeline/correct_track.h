// Replays corrections by hand on the automatic track of a video (tracker/correction.h).
#pragma once

#include <string>
#include <vector>

#include "src/pipeline/track_video.h"
#include "tracker/correction.h"

namespace zygoma {

// Reads the video once more, as far as corrections reach, and changes the contours they influence;
// all others keep their bits. Holds the pictures of the face (0.2 MB each) of the frames that
// overlapping corrections reach together. Throws InputError naming a correction whose frame is not
// in the video.
void correct_track(const std::vector<Correction>& corrections,
                   TrackedVideo& tracked,
                   StageObserver& observer,
                   const StopQuestion& stop);

}  // namespace zygoma
