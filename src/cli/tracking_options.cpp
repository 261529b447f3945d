#include "src/cli/tracking_options.h"

#include "src/base/check.h"
#include "src/io/contours_file.h"
#include "src/io/corrections_file.h"
#include "src/pipeline/correct_track.h"

namespace zygoma {

void TrackingOptions::declare(OptionSink& options) {
  options.text(
      "--init",
      init_path_,
      "FILE",
      "contours of the first frame (JSON: {\"contours\": {\"brow_left\": [[x, y], ...], ...}}) "
      "instead of the automatic start");
  options.text(
      "--corrections",
      corrections_path_,
      "FILE",
      "springs, pins and volcanoes that pull contours right, replayed on the track (a JSON "
      "object per line, see docs/formats.md)");
  options.text("--cascades",
               tracker_.cascade_folder,
               "FOLDER",
               "OpenCV's haarcascades (default: where its package puts them)");
}

TrackedVideo TrackingOptions::track(const std::string& video_path, RunContext& context) const {
  std::optional<ContourSet> initial;
  if (!init_path_.empty()) initial = read_initial_contours(init_path_);
  std::vector<Correction> corrections;
  if (!corrections_path_.empty()) corrections = read_corrections(corrections_path_);
  TrackedVideo tracked = track_video(video_path, initial, tracker_, context.progress, context.stop);
  try {
    correct_track(corrections, tracked, context.progress, context.stop);
  } catch (const InputError& error) {
    throw InputError(corrections_path_ + ": " + error.what());
  }
  return tracked;
}

}  // namespace zygoma
