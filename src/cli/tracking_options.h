// Options of the commands that track a video.
#pragma once

#include <optional>
#include <string>

#include "src/cli/command.h"
#include "src/pipeline/track_video.h"

namespace zygoma {

class TrackingOptions {
 public:
  void declare(OptionSink& options);

  // Tracks the video; throws InputError when no frame of it shows a face.
  TrackedVideo track(const std::string& video_path, RunContext& context) const;

 private:
  TrackerOptions tracker_;
  std::string init_path_;
  std::string corrections_path_;
};

}  // namespace zygoma
