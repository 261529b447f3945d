#include "src/cli/tracking_options.h"

#include "src/base/check.h"
#include "src/io/contours_file.h"

namespace zygoma {

void TrackingOptions::declare(OptionSink& options) {
  options.text("--init",
               init_path_,
               "FILE",
               "contours of the first frame (JSON) instead of the automatic start");
  options.text("--cascades",
               tracker_.cascade_folder,
               "FOLDER",
               "OpenCV's haarcascades; default: where the packages put them");
}

TrackedVideo TrackingOptions::track(const std::string& video_path, RunContext& context) const {
  std::optional<ContourSet> initial;
  if (!init_path_.empty()) initial = read_initial_contours(init_path_);
  TrackedVideo tracked = track_video(video_path, initial, tracker_, context.progress, context.stop);
  const std::string num_frames = std::to_string(tracked.contours.size());
  require(tracked.frames_with_face > 0 || tracked.stopped,
          video_path + ": no face found in " + num_frames +
              " frames; expected a frontal face at least 80 pixels wide, or contours given with "
              "--init");
  return tracked;
}

}  // namespace zygoma
