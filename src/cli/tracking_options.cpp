#include "src/cli/tracking_options.h"

#include "src/io/contours_file.h"

namespace zygoma {

void TrackingOptions::declare(OptionSink& options) {
  options.text(
      "--init",
      init_path_,
      "FILE",
      "contours of the first frame (JSON: {\"contours\": {\"brow_left\": [[x, y], ...], ...}}) "
      "instead of the automatic start");
  options.text("--cascades",
               tracker_.cascade_folder,
               "FOLDER",
               "OpenCV's haarcascades (default: where its package puts them)");
}

TrackedVideo TrackingOptions::track(const std::string& video_path, RunContext& context) const {
  std::optional<ContourSet> initial;
  if (!init_path_.empty()) initial = read_initial_contours(init_path_);
  return track_video(video_path, initial, tracker_, context.progress, context.stop);
}

}  // namespace zygoma
