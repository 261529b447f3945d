// zygoma track: a video in, the nine contours of every frame out.
#include <ostream>

#include "src/cli/command.h"
#include "src/cli/session_parts.h"
#include "src/cli/tracking_options.h"
#include "src/io/contours_file.h"
#include "src/io/output_folder.h"
#include "src/pipeline/overlay_video.h"

namespace zygoma {
namespace {

class TrackCommand : public Command {
 public:
  std::string name() const override { return "track"; }
  std::string help() const override {
    return "follow the nine contours of the face through a video";
  }
  std::string details() const override {
    return "Writes into the folder: contours.csv (frame, time, contour, node, pixels, confidence), "
           "overlay.mp4 (the video with the contours drawn in) and session.json (options, "
           "versions, times).";
  }
  std::string example() const override { return "clip.mp4 -o result"; }
  int rank() const override { return 2; }
  void declare(OptionSink& options) override {
    options.positional(
        "VIDEO", video_path_, "any file FFmpeg reads, showing a face from the front");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    options.flag("--no-overlay", no_overlay_, "leave out overlay.mp4");
    tracking_.declare(options);
  }
  int run(RunContext& context) override {
    const OutputFolder folder(folder_);
    require_not_the_input(folder / "overlay.mp4", video_path_);
    const TrackedVideo tracked = tracking_.track(video_path_, context);
    write_contours_csv(folder / "contours.csv", tracked.contours);

    Session session = begin_session(name(), context);
    session.source = source_of(tracked);
    session.stopped_early = tracked.stopped;
    session.stages.push_back(stage_of(tracked));
    if (!no_overlay_ && !tracked.stopped) {
      session.stages.push_back(stage_of(write_overlay_video(
          video_path_, tracked.contours, folder / "overlay.mp4", context.progress, context.stop)));
    }
    write_session(folder / "session.json", session);
    for (const std::string& remark : remarks(tracked)) context.progress.note(remark);
    context.out << tracked.contours.size() << " frames tracked: " << folder / "contours.csv"
                << '\n';
    return 0;
  }

 private:
  std::string video_path_;
  std::string folder_ = "zygoma-out";
  bool no_overlay_ = false;
  TrackingOptions tracking_;
};

}  // namespace

std::unique_ptr<Command> make_track_command() { return std::make_unique<TrackCommand>(); }

}  // namespace zygoma
