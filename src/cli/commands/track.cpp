// zygoma track: pictures in, the contours of every frame out.
#include <charconv>
#include <ostream>

#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/session_parts.h"
#include "src/cli/tracking_options.h"
#include "src/io/contours_file.h"
#include "src/io/output_folder.h"
#include "src/pipeline/overlay_video.h"

namespace zygoma {
namespace {

constexpr int kLastCamera = 255;

class TrackCommand : public Command {
 public:
  std::string name() const override { return "track"; }
  std::string help() const override {
    return "follow the contours of the face through a video, numbered pictures or a camera";
  }
  std::string details() const override {
    return "Writes into the folder: contours.csv (frame, time, contour, node, pixels, confidence), "
           "overlay.mp4 (the video with its contours, brows and mouth close with the head held "
           "still, confidence over time) and session.json (options, versions, times). Pictures "
           "that come only once, from a camera or a pipe, are kept in recording.mp4; a camera is "
           "followed until Ctrl-C or for --duration seconds.";
  }
  std::string example() const override { return "clip.mp4 -o result"; }
  int rank() const override { return 2; }
  void declare(OptionSink& options) override {
    options.optional_positional("VIDEO",
                                video_path_,
                                "any file FFmpeg reads, or numbered pictures such as "
                                "frames/%04d.png, showing a face from the front");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    options.flag("--no-overlay", no_overlay_, "leave out overlay.mp4");
    options.text("--camera",
                 camera_,
                 "N",
                 "follow the camera /dev/videoN live, instead of a video, until Ctrl-C");
    options.text("--camera-size", camera_size_, "WxH", "pictures asked of it, such as 640x480");
    options.number(
        "--duration", duration_s_, {0.0, 86400.0}, "end after so many seconds; 0 = never");
    tracking_.declare(options);
  }
  int run(RunContext& context) override {
    const VideoSource source = chosen_source();
    const bool once = !can_be_read_again(source);
    const OutputFolder folder(folder_);
    for (const char* written : {"overlay.mp4", "recording.mp4"}) {
      require_not_the_input(folder / written, source.path);
    }
    const TrackLimits limits{duration_s_, once ? folder / "recording.mp4" : std::string()};
    const TrackedVideo tracked = tracking_.track(source, context, limits);
    write_contours_csv(folder / "contours.csv", tracked.contours);

    // Ctrl-C is how a camera is usually ended: what follows is still wanted.
    const bool cut_short = tracked.stopped && !source.is_camera;
    const StopQuestion stop = source.is_camera ? StopQuestion() : context.stop;
    Session session = begin_session(name(), context);
    session.source = source_of(tracked);
    session.stopped_early = cut_short;
    session.stages.push_back(stage_of(tracked));
    if (!no_overlay_ && !cut_short && !tracked.contours.empty()) {
      session.stages.push_back(
          stage_of(write_overlay_video(tracked, folder / "overlay.mp4", context.progress, stop)));
    }
    write_session(folder / "session.json", session);
    for (const std::string& remark : remarks(tracked)) context.progress.note(remark);
    context.out << tracked.contours.size() << " frames tracked: " << folder / "contours.csv"
                << '\n';
    return 0;
  }

 private:
  VideoSource chosen_source() const {
    if (camera_.empty()) {
      require(!video_path_.empty(),
              "no video given, expected a file, numbered pictures such as frames/%04d.png, or "
              "--camera N");
      require(camera_size_.empty(), "--camera-size: needs --camera");
      return tracking_.source(video_path_);
    }
    require(video_path_.empty(),
            "--camera: a video is given too (" + video_path_ + "), expected one of them");
    VideoSource camera = camera_source(camera_number());
    camera.frames_per_s = tracking_.source("").frames_per_s;
    camera.camera_size = camera_size_;
    return camera;
  }

  int camera_number() const {
    int number = -1;
    const char* end = camera_.data() + camera_.size();
    const auto read = std::from_chars(camera_.data(), end, number);
    require(read.ec == std::errc() && read.ptr == end && number >= 0 && number <= kLastCamera,
            "--camera: '" + camera_ + "', expected the number of a camera, as 0 in /dev/video0");
    return number;
  }

  std::string camera_;  // its number
  std::string camera_size_;
  double duration_s_ = 0.0;
  std::string video_path_;
  std::string folder_ = "zygoma-out";
  bool no_overlay_ = false;
  TrackingOptions tracking_;
};

}  // namespace

std::unique_ptr<Command> make_track_command() { return std::make_unique<TrackCommand>(); }

}  // namespace zygoma
