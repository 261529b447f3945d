// zygoma tradeoff: what accuracy costs in time on this machine.
#include "src/pipeline/tradeoff.h"

#include <fstream>
#include <ostream>

#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/session_parts.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/output_folder.h"
#include "src/io/scene_file.h"
#include "src/pipeline/machine_load.h"
#include "src/pipeline/tradeoff_clip.h"
#include "src/pipeline/tradeoff_tissue.h"

namespace zygoma {
namespace {

// As the kernel describes it; empty if it does not.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return {};
}

class TradeoffCommand : public Command {
 public:
  std::string name() const override { return "tradeoff"; }
  std::string help() const override {
    return "measure what accuracy costs in time on this machine: tissue, and for a clip the "
           "tracker "
           "and the estimation";
  }
  std::string details() const override {
    return "Tissue: a motion settled with two or three layers, 300 to 2000 surface vertices, three "
           "tolerances, the explicit steps of 1992 and without each of its effects, against 4000 "
           "vertices converged to 1e-6 of the load. With a CLIP also the tracker (prediction, "
           "models, nodes, iterations, Gaussian levels, second looks) and the estimation (closed "
           "form, three levels of the face model, live and in windows), against the truth where it "
           "is given, else against the most careful setting. Writes into the folder: tradeoff.csv, "
           "tradeoff.svg (error over time with the front: what nothing beats in both) and "
           "session.json with the machine. The levels of --quality are marked.";
  }
  std::string example() const override { return "clip.mp4 -o result"; }
  int rank() const override { return 8; }
  void declare(OptionSink& options) override {
    options.optional_positional(
        "CLIP", clip_path_, "a video of a face from the front; without it only the tissue");
    options.text(
        "--scene",
        scene_path_,
        "FILE",
        "a scene whose head, effects and motion are used; without it a smile, raised brows "
        "and an opening jaw");
    options.text("--truth", truth_path_, "FILE", "known contractions (CSV) of the clip");
    options.text(
        "--truth-contours", truth_contours_path_, "FILE", "known contours (CSV) of the clip");
    options.number("--duration", duration_s_, {0.5, 60.0}, "how much of the clip is used, s");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
  }

  int run(RunContext& context) override {
    Scene scene;
    scene.motion = tradeoff_motion();
    if (!scene_path_.empty()) scene = read_scene(scene_path_);
    TradeoffClip clip = read_clip();
    const OutputFolder folder(folder_);
    Session session = begin_session(name(), context);
    session.libraries.emplace_back("processor", processor_name());
    const Stopwatch watch;
    const LoadMeter load;
    std::vector<TradeoffStage> stages;
    const auto add = [&](const auto& measure) {
      if (!stages.empty() && stages.back().stopped) return;
      const Stopwatch stage_watch;
      stages.push_back(measure());
      session.stages.push_back(stage_of(StageFigures{stages.back().name,
                                                     static_cast<int>(stages.back().rows.size()),
                                                     stage_watch.elapsed_ms()}));
    };
    if (!clip_path_.empty()) {
      add([&] {
        return measure_tracker(
            clip, tracker_choices(), tracker_reference(), context.progress, context.stop);
      });
      add([&] {
        return measure_retarget(clip,
                                usual_face(),
                                retarget_choices(),
                                retarget_reference(),
                                context.progress,
                                context.stop);
      });
    }
    add([&] {
      return measure_tissue(
          scene, tissue_choices(scene), tissue_reference(), context.progress, context.stop);
    });
    session.stopped_early = stages.back().stopped;
    session.stages.push_back(stage_of(StageFigures{"tradeoff", 1, watch.elapsed_ms()}));
    session.stages.back().figures.emplace_back("share_of_other_programs", load.share_of_others());
    write_tradeoff_csv(folder / "tradeoff.csv", stages);
    write_tradeoff_plot(folder / "tradeoff.svg", stages);
    write_session(folder / "session.json", session);
    for (const TradeoffStage& stage : stages) context.out << front_table(stage);
    if (!stages.front().rows.empty()) {
      context.out << "error over time: " << folder / "tradeoff.svg" << '\n';
    }
    return 0;
  }

 private:
  TradeoffClip read_clip() const {
    require(!clip_path_.empty() || (truth_path_.empty() && truth_contours_path_.empty()),
            "--truth, --truth-contours: given without a clip, expected one of which they are true");
    TradeoffClip clip;
    if (clip_path_.empty()) return clip;
    clip.video = VideoSource(clip_path_);
    require(can_be_read_again(clip.video), clip_path_ + ": can be read once only, expected a file");
    { const VideoReader probe(clip.video); }  // a bad file is refused before any work begins
    clip.duration_s = duration_s_;
    if (!truth_path_.empty()) clip.true_contractions = read_contractions_csv(truth_path_);
    if (!truth_contours_path_.empty()) clip.true_contours = read_contours_csv(truth_contours_path_);
    return clip;
  }

  // That contractions are estimated with.
  static Scene usual_face() {
    Scene scene;
    face_quality("standard").apply(scene.head, scene.tissue, scene.settle);
    return scene;
  }

  std::string clip_path_;
  std::string scene_path_;
  std::string truth_path_;
  std::string truth_contours_path_;
  double duration_s_ = 6.0;
  std::string folder_ = "zygoma-out";
};

}  // namespace

std::unique_ptr<Command> make_tradeoff_command() { return std::make_unique<TradeoffCommand>(); }

}  // namespace zygoma
