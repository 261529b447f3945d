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

  // The video or the numbered pictures of that name.
  VideoSource source(const std::string& video_path) const;

  // Throws InputError where an option is given that `who` decides.
  void leave_quality_to(const std::string& who) const;

  // Second looks are those of `limits`, unless an option says which. Tracks the video; throws
  // InputError when no frame of it shows a face.
  TrackedVideo track(const VideoSource& source, RunContext& context, TrackLimits limits = {}) const;

 private:
  double frames_per_s_ = 0.0;
  TrackerOptions tracker_;
  std::string init_path_;
  std::string landmarks_path_;
  std::string landmarks_as_ = "start";
  std::string second_look_ = "auto";
  std::string corrections_path_;
  std::string stepping_ = "implicit";
};

}  // namespace zygoma
