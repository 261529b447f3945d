// zygoma run: a video in, its reconstruction by muscles out. track, retarget and animate in one.
#include <atomic>
#include <cstdio>
#include <functional>
#include <future>
#include <ostream>

#include "retarget/measure_response.h"
#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/face_options.h"
#include "src/cli/retarget_options.h"
#include "src/cli/session_parts.h"
#include "src/cli/tracking_options.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/output_folder.h"
#include "src/io/video_reader.h"
#include "src/pipeline/comparison.h"

namespace zygoma {
namespace {

// Calls `what` when its scope is left, by return or exception.
struct OnLeaving {
  std::function<void()> what;
  ~OnLeaving() { what(); }
};

class RunCommand : public Command {
 public:
  std::string name() const override { return "run"; }
  std::string help() const override {
    return "a video in, muscle contractions and the animated face out: track, retarget and animate "
           "in one";
  }
  std::string details() const override {
    return "Writes into the folder: contours.csv (the contours in every frame, pixels), "
           "contractions.csv (muscles and jaw in every frame, 0 to 1), contractions.svg (the same "
           "as curves), retarget_report.json (frames to look at), reconstruction.mp4 (the video "
           "with its contours, the animated face, a bar per muscle; with --smooth it shows the "
           "filtered contractions) and session.json (options, versions, times).";
  }
  std::string example() const override { return "clip.mp4 -o result"; }
  int rank() const override { return 1; }
  void declare(OptionSink& options) override {
    options.positional("VIDEO",
                       video_path_,
                       "any file FFmpeg reads, or numbered pictures such as frames/%04d.png, "
                       "showing a face from the front");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    tracking_.declare(options);
    retargeting_.declare(options);
    face_.declare(options);
    animation_.declare(options);
    options.text("--truth", truth_path_, "FILE", "known contractions (CSV) to compare with");
    options.text(
        "--truth-contours", truth_contours_path_, "FILE", "known contours (CSV) to compare with");
  }

  int run(RunContext& context) override {
    const Stopwatch watch;
    read_truth();
    face_.check();
    retargeting_.prepare();
    const OutputFolder folder(folder_);
    require_not_the_input(folder / "reconstruction.mp4", video_path_);
    const VideoSource source = tracking_.source(video_path_);
    require(can_be_read_again(source),
            video_path_ + ": can be read once only, expected a file; zygoma track records it");
    { const VideoReader probe(source); }  // a bad file is refused before any work begins
    Session session = begin_session(name(), context);

    std::atomic<bool> abandoned{false};
    std::future<PreparedFace> prepared = std::async(
        std::launch::async, [&] { return prepare_face([&] { return abandoned.load(); }); });
    // Whatever ends this run early, a video without a face or a stop, ends the preparation too.
    const OnLeaving abandon{[&] { abandoned = true; }};
    const TrackedVideo tracked = tracking_.track(source, context);
    write_contours_csv(folder / "contours.csv", tracked.contours);
    session.source = source_of(tracked);
    session.stages.push_back(stage_of(tracked));
    std::vector<std::string> notes = remarks(tracked);

    bool stopped = tracked.stopped;
    if (!stopped) {
      auto [face, response] = prepared.get();
      append(notes, {face.remark});
      const Retargeted retargeted =
          retargeting_.retarget(tracked.contours, response, face.simulator, context);
      retargeting_.write(retargeted, folder);
      session.muscles = retargeted.track.muscles;
      session.neutral_frame = retargeted.report.neutral_frame;
      session.stages.push_back(stage_of(retargeted.report, retargeted.figures));
      append(notes, retargeted.remarks);
      append(notes, remarks(retargeted.report));
      stopped = context.stop();
      if (!stopped) {
        const AnimationReport animation = animate_face(retargeted.shown(),
                                                       face.simulator,
                                                       face.anatomy,
                                                       Performance{source, tracked.contours},
                                                       folder / "reconstruction.mp4",
                                                       animation_.animate_options(),
                                                       context.progress,
                                                       context.stop);
        stopped = animation.stopped;
        session.stages.push_back(stage_of(animation));
        append(notes, remarks(animation));
        if (retargeted.smooth) append(notes, {"the animation shows contractions_filtered.csv"});
        append(notes, {face_.verdict(animation.settle_figures.frame_ms())});
        print_comparison(retargeted.track, tracked.contours, context.out);
      }
    }
    session.stopped_early = stopped;
    session.stages.push_back(
        stage_of(StageFigures{"whole run", session.source.num_frames, watch.elapsed_ms()}));
    write_session(folder / "session.json", session);
    for (const std::string& note : notes) {
      if (!note.empty()) context.progress.note(note);
    }
    print_figures(session, tracked, context.out);
    return 0;
  }

 private:
  struct PreparedFace {
    AssembledFace face;
    FaceResponse response;
  };

  // Does not depend on the video: done while that is tracked.
  PreparedFace prepare_face(const StopQuestion& stop) const {
    AssembledFace face = face_.assemble();
    FaceResponse response = measure_response(face.simulator, {}, stop);
    return {std::move(face), std::move(response)};
  }

  void read_truth() {
    if (!truth_path_.empty()) truth_ = read_contractions_csv(truth_path_);
    if (!truth_contours_path_.empty()) truth_contours_ = read_contours_csv(truth_contours_path_);
  }

  static void append(std::vector<std::string>& notes, const std::vector<std::string>& more) {
    notes.insert(notes.end(), more.begin(), more.end());
  }

  void print_comparison(const ContractionTrack& track,
                        const std::vector<ContourSet>& contours,
                        std::ostream& out) const {
    if (!truth_contours_.empty()) {
      out << "Contours against the truth:\n"
          << contour_table(compare_contours(contours, truth_contours_));
    }
    if (!truth_.frames.empty()) {
      out << "Contractions against the truth (0 to 1):\n"
          << contraction_table(compare_contractions(track, truth_));
    }
  }

  void print_figures(const Session& session, const TrackedVideo& tracked, std::ostream& out) const {
    for (const SessionStage& stage : session.stages) {
      char line[120];
      std::snprintf(line,
                    sizeof line,
                    "%-10s %8.2f s  %7.2f ms per frame\n",
                    stage.name.c_str(),
                    stage.ms_total * 1e-3,
                    stage.ms_per_frame);
      out << line;
    }
    if (tracked.contours.size() > 1) {
      const double clip_s = tracked.contours.back().time_s - tracked.contours.front().time_s;
      char line[120];
      std::snprintf(line,
                    sizeof line,
                    "the clip lasts %.2f s: %.2f times real time\n",
                    clip_s,
                    clip_s / (session.stages.back().ms_total * 1e-3));
      out << line;
    }
    out << "results: " << folder_ << '\n';
  }

  std::string video_path_;
  std::string folder_ = "zygoma-out";
  std::string truth_path_;
  std::string truth_contours_path_;
  ContractionTrack truth_;
  std::vector<ContourSet> truth_contours_;
  TrackingOptions tracking_;
  RetargetingOptions retargeting_;
  FaceOptions face_;
  AnimationOptions animation_;
};

}  // namespace

std::unique_ptr<Command> make_run_command() { return std::make_unique<RunCommand>(); }

}  // namespace zygoma
