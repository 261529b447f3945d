// zygoma animate: contractions.csv or keyframes in, a video of the physical face out.
#include <ostream>

#include "face/motion.h"
#include "face/muscle_table.h"
#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/face_options.h"
#include "src/cli/session_parts.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/output_folder.h"
#include "src/io/scene_file.h"

namespace zygoma {
namespace {

class AnimateCommand : public Command {
 public:
  std::string name() const override { return "animate"; }
  std::string help() const override { return "move the physical face by contractions and film it"; }
  std::string details() const override {
    return "Contractions may come from `zygoma run`, `retarget` or `synth`, or be written by hand: "
           "the "
           "columns frame, timestamp, confidence, success, head_x, head_y, head_scale, head_roll, "
           "jaw and one per muscle. A file that ends in .json holds keyframes: poses at times, as "
           "expressions, action units or muscles, with a smooth motion in between, for example "
           "{\"keys\": [{\"time_s\": 0}, {\"time_s\": 0.6, \"pose\": \"6+12\"}]}.";
  }
  std::string example() const override {
    return "result/contractions.csv --video clip.mp4 --contours result/contours.csv -o face.mp4";
  }
  int rank() const override { return 4; }
  void declare(OptionSink& options) override {
    options.positional(
        "CONTRACTIONS", contractions_path_, "contractions.csv of any command, or keyframes.json");
    options.text("-o,--output", output_, "FILE", "the video to write");
    options.text("--video", video_path_, "FILE", "the performer's video, shown beside the face");
    options.text("--contours", contours_path_, "FILE", "contours.csv to draw into that video");
    options.text("--face",
                 face_path_,
                 "SCENE",
                 "a scene file whose head, tissue and effects are animated instead of the usual "
                 "face: the same contractions drive any face; its motion is not used");
    face_.declare(options);
    animation_.declare(options);
  }
  int run(RunContext& context) override {
    require(contours_path_.empty() || !video_path_.empty(),
            "--contours: needs --video, the pictures they are drawn into");
    require_not_the_input(output_, contractions_path_);
    require_not_the_input(output_, video_path_);
    const ContractionTrack track = read_track();
    std::optional<Performance> performance;
    if (!video_path_.empty()) {
      performance.emplace();
      performance->video = video_path_;
      if (!contours_path_.empty()) performance->contours = read_contours_csv(contours_path_);
    }
    AssembledFace face = assemble(track);
    if (!face.remark.empty()) context.progress.note(face.remark);
    const AnimationReport report = animate_face(track,
                                                face.simulator,
                                                face.anatomy,
                                                performance,
                                                output_,
                                                animation_.animate_options(),
                                                context.progress,
                                                context.stop);
    for (const std::string& remark : remarks(report)) context.progress.note(remark);
    const std::string verdict = face_.verdict(report.settle_figures.frame_ms());
    if (!verdict.empty()) context.progress.note(verdict);
    context.out << report.num_frames << " frames animated: " << output_ << '\n';
    return 0;
  }

 private:
  AssembledFace assemble(const ContractionTrack& track) const {
    if (face_path_.empty()) return face_.assemble(&track);
    const ChosenScene chosen = face_.scene(face_path_, &track);
    auto anatomy = std::make_shared<const Anatomy>(
        make_generic_head(chosen.scene.identity, chosen.scene.head));
    return {anatomy, make_simulator(chosen.scene, anatomy), chosen.remark};
  }

  ContractionTrack read_track() const {
    if (!contractions_path_.ends_with(".json")) return read_contractions_csv(contractions_path_);
    require(video_path_.empty(),
            "--video: goes with contractions read from it, not with keyframes");
    const Motion motion = read_keyframes(contractions_path_);
    return sample_motion(motion, muscles_used(motion, standard_muscle_names()));
  }

  std::string contractions_path_;
  std::string output_ = "animation.mp4";
  std::string video_path_;
  std::string contours_path_;
  std::string face_path_;
  FaceOptions face_;
  AnimationOptions animation_;
};

}  // namespace

std::unique_ptr<Command> make_animate_command() { return std::make_unique<AnimateCommand>(); }

}  // namespace zygoma
