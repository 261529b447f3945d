// zygoma run: a video in, its reconstruction by muscles out. track, retarget and animate in one.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <functional>
#include <future>
#include <ostream>

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
#include "src/pipeline/machine_load.h"
#include "src/pipeline/pick_quality.h"
#include "src/pipeline/pick_run.h"

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
           "filtered contractions) and session.json (options, versions, times). --quality sets "
           "tracker, estimation and tissue together; "
           "--budget picks a quality that brings the whole run, start-up and all, within so many "
           "ms for every frame of the clip.";
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
    face_.declare(options, FaceOptions::BudgetOf::kWholeRun);
    animation_.declare(options);
    options.text("--truth", truth_path_, "FILE", "known contractions (CSV) to compare with");
    options.text(
        "--truth-contours", truth_contours_path_, "FILE", "known contours (CSV) to compare with");
  }

  int run(RunContext& context) override {
    const Stopwatch watch;
    const LoadMeter load;
    read_truth();
    check_options();
    const OutputFolder folder(folder_);
    require_not_the_input(folder / "reconstruction.mp4", video_path_);
    const VideoSource source = tracking_.source(video_path_);
    require(can_be_read_again(source),
            video_path_ + ": can be read once only, expected a file; zygoma track records it");
    Choice choice = choose(source);  // a bad file is refused before any work begins
    Story story{begin_session(name(), context)};
    Session& session = story.session;

    std::atomic<bool> abandoned{false};
    std::future<RunFaces> prepared = std::async(std::launch::async, [&, quality = choice.quality] {
      return prepare_faces(quality, [&] { return abandoned.load() || context.stop(); });
    });
    // Whatever ends this run early, a video without a face or a stop, ends the preparation too.
    const OnLeaving abandon{[&] { abandoned = true; }};
    TrackLimits limits;
    limits.second_looks = choice.quality.second_looks;
    const TrackedVideo tracked = tracking_.track(source, context, limits);
    write_contours_csv(folder / "contours.csv", tracked.contours);
    session.source = source_of(tracked);
    session.stages.push_back(stage_of(tracked));
    append(story.notes, remarks(tracked));

    RunFaces faces;
    if (!tracked.stopped) {
      faces = prepared.get();
      if (face_.budget_ms() > 0.0) {
        faces = pick(std::move(faces), tracked, folder / "trial.mp4", watch, context, choice);
      }
    }
    session.stopped_early = tracked.stopped || context.stop();
    if (!session.stopped_early) reconstruct(tracked, choice, faces, folder, context, story);
    session.stages.push_back(
        stage_of(StageFigures{"whole run", session.source.num_frames, watch.elapsed_ms()}));
    const double others = load.share_of_others();
    add_figures(choice, others, session.stages.back());
    write_session(folder / "session.json", session);
    append(story.notes, {verdict(choice, story, others)});
    for (const std::string& note : story.notes) {
      if (!note.empty()) context.progress.note(note);
    }
    print_figures(session, tracked, context.out);
    return 0;
  }

 private:
  // What this run is done with.
  struct Choice {
    RunQuality quality;
    double expected_ms = 0.0;  // per frame, of the whole run; 0: nobody has tried
    std::string remark;
  };

  // How it goes.
  struct Story {
    Session session;
    std::vector<std::string> notes{};
    double residual_px = 0.0;
  };

  // From contours to the film of the face.
  void reconstruct(const TrackedVideo& tracked,
                   const Choice& choice,
                   RunFaces& faces,
                   const OutputFolder& folder,
                   RunContext& context,
                   Story& story) {
    if (!choice.remark.empty()) context.progress.note(choice.remark);
    retargeting_.set_usual(choice.quality);
    const Retargeted retargeted =
        retargeting_.retarget(tracked.contours, faces.response, faces.estimation(), context);
    retargeting_.write(retargeted, folder);
    Session& session = story.session;
    story.residual_px = retargeted.report.median_residual_px;
    session.muscles = retargeted.track.muscles;
    session.neutral_frame = retargeted.report.neutral_frame;
    session.stages.push_back(stage_of(retargeted.report, retargeted.figures));
    append(story.notes, retargeted.remarks);
    append(story.notes, remarks(retargeted.report));
    session.stopped_early = context.stop();
    if (session.stopped_early) return;
    const AnimationReport animation =
        animate_face(retargeted.shown(),
                     *faces.drawn,
                     faces.anatomy,
                     Performance{tracked.source, tracked.contours},
                     folder / "reconstruction.mp4",
                     animation_.animate_options(choice.quality.samples_per_pixel),
                     context.progress,
                     context.stop);
    session.stopped_early = animation.stopped;
    session.stages.push_back(stage_of(animation));
    append(story.notes, remarks(animation));
    if (retargeted.smooth) append(story.notes, {"the animation shows contractions_filtered.csv"});
    print_comparison(retargeted.track, tracked.contours, context.out);
  }

  void check_options() {
    face_.check();
    retargeting_.prepare();
    const bool budget = face_.budget_ms() > 0.0;
    if (!budget && face_.tolerance_mm() == 0.0) return;
    const std::string who = budget ? "--budget" : "--tolerance";
    tracking_.leave_quality_to(who);
    retargeting_.leave_quality_to(who);
  }

  // The quality asked for; of a budget the quickest, to begin with.
  Choice choose(const VideoSource& source) const {
    const VideoReader probe(source);
    Choice choice;
    if (face_.budget_ms() > 0.0) {
      // The tracker has to know before the clip does; the faces wait for what tracking tells.
      const auto about_frames =
          static_cast<std::size_t>(std::max(0, probe.info().about_num_frames));
      choice.quality = run_qualities().front();
      choice.quality.second_looks =
          run_qualities()[guess_quality(face_.budget_ms(), about_frames)].second_looks;
      return choice;
    }
    choice.quality = face_.tolerance_mm() > 0.0
                         ? run_qualities()[pick_for_run_tolerance(face_.tolerance_mm())]
                         : run_quality(face_.quality());
    if (choice.quality.name != run_quality("standard").name) choice.remark = remark_on(choice);
    face_.refine(choice.quality.face);
    face_.refine(choice.quality.estimation);
    return choice;
  }

  // Tries qualities on the tracked clip.
  RunFaces pick(RunFaces first,
                const TrackedVideo& tracked,
                const std::string& scratch,
                const Stopwatch& since_start,
                RunContext& context,
                Choice& choice) const {
    const RunTask task{tracked,
                       retargeting_.estimation(),
                       retargeting_.profile(),
                       [this](const RunQuality& quality) {
                         return animation_.animate_options(quality.samples_per_pixel);
                       },
                       scratch,
                       context.stop};
    context.progress.begin("try qualities", 0);
    RunPick found = pick_for_run(
        face_.budget_ms(), std::move(first), task, [&] { return since_start.elapsed_ms(); });
    context.progress.end();
    choice.quality = run_qualities()[found.quality];
    choice.expected_ms = found.expected_ms;
    choice.remark = remark_on(choice);
    const std::string forecast = budget_forecast(found.expected_ms, face_.budget_ms());
    if (!forecast.empty()) choice.remark += "; " + forecast;
    return std::move(found.faces);
  }

  static const char* level_word(FaceLevel level) {
    switch (level) {
      case FaceLevel::kLinear:
        return "linear estimation";
      case FaceLevel::kCorrected:
        return "corrected estimation";
      default:
        return "estimation by the lattice";
    }
  }

  static std::string remark_on(const Choice& choice) {
    const RunQuality& quality = choice.quality;
    char text[300];
    std::snprintf(
        text,
        sizeof text,
        "quality %s: %s layers, %d surface vertices, %s; expected %.2f mm RMS of the skin "
        "from the reference, contractions within %.3f RMS as on the sample clip",
        quality.name.c_str(),
        quality.face.bi_layer ? "two" : "three",
        quality.face.surface_vertices,
        level_word(quality.level),
        quality.face.expected_rms_mm,
        quality.expected_contraction_rms);
    std::string remark = text;
    if (choice.expected_ms > 0.0) {
      std::snprintf(text, sizeof text, ", %.1f ms per frame", choice.expected_ms);
    } else {
      std::snprintf(text,
                    sizeof text,
                    "; where it was measured %.0f ms per frame after tracking, ready in %.1f s",
                    quality.about_frame_ms,
                    1e-3 * quality.about_start_ms);
    }
    return remark + text;
  }

  void add_figures(const Choice& choice, double others, SessionStage& stage) const {
    stage.figures.emplace_back("share_of_other_programs", others);
    if (face_.budget_ms() == 0.0) return;
    stage.figures.emplace_back("budget_ms_per_frame", face_.budget_ms());
    stage.figures.emplace_back("expected_ms_per_frame", choice.expected_ms);
  }

  // How it turned out; empty where nothing was asked for.
  std::string verdict(const Choice& choice, const Story& story, double others) const {
    constexpr double kIdle = 0.1;
    if (choice.remark.empty() || story.session.stopped_early) return {};
    const SessionStage& whole = story.session.stages.back();
    char text[200];
    std::snprintf(text, sizeof text, "the whole run took %.1f ms per frame", whole.ms_per_frame);
    std::string line = text;
    if (face_.budget_ms() > 0.0) {
      std::snprintf(text, sizeof text, ", expected were %.1f, ", choice.expected_ms);
      line += text + budget_verdict(whole.ms_per_frame, face_.budget_ms());
    }
    std::snprintf(text, sizeof text, "; the contours are met within %.2f px", story.residual_px);
    line += text;
    if (others > kIdle) {
      std::snprintf(text,
                    sizeof text,
                    "; the machine was under load, other programs took %.0f %% of its processors",
                    100.0 * others);
      line += text;
    }
    return line;
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
