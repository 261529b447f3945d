// zygoma express: an expression in, a picture or a video of it out.
#include <cstdio>
#include <ostream>

#include "face/facs.h"
#include "face/motion.h"
#include "face/muscle_field.h"
#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/effect_options.h"
#include "src/cli/face_options.h"
#include "src/io/output_folder.h"
#include "src/io/picture_file.h"
#include "src/pipeline/face_film.h"
#include "src/pipeline/simulate_scene.h"

namespace zygoma {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

class ExpressCommand : public Command {
 public:
  std::string name() const override { return "express"; }
  std::string help() const override { return "show an expression, action units or muscles"; }
  std::string details() const override {
    return "EXPRESSION is a name (surprise, waters:anger), a string of FACS action units with side "
           "and intensity (1+2+5B+26, R12A+R14A, T24+12:60%), or muscle=value,... "
           "(zygomaticus_major_L=0.8,jaw=0.2; without side: both). `zygoma face list` shows what "
           "there is. A video goes from neutral to the expression and back.";
  }
  std::string example() const override { return "1+2+5B+26 -o surprise.mp4"; }
  int rank() const override { return 6; }
  void declare(OptionSink& options) override {
    options.positional("EXPRESSION", text_, "name, action units or muscle=value,...");
    options.text("-o,--output", output_, "FILE", "the picture (.png, .jpg) or video (.mp4)");
    options.number("--jaw",
                   jaw_deg_,
                   {0.0, 20.0},
                   "open the jaw at least this far, degrees; the expression may open it further");
    options.text(
        "--scene", scene_path_, "FILE", "head, tissue, effects and solver of a scene file");
    effects_.declare_choice(options);
    face_.declare(options);
    animation_.declare(options);
  }

  int run(RunContext& context) override {
    const bool is_video = output_.ends_with(".mp4");
    if (!is_video) {
      require(output_.ends_with(".png") || output_.ends_with(".jpg") || output_.ends_with(".jpeg"),
              output_ + ": expected a name that ends in .png, .jpg or .mp4");
    }
    if (!scene_path_.empty()) require_not_the_input(output_, scene_path_);
    const Pose pose = pose_of(text_);
    const ChosenScene chosen = face_.scene(scene_path_);
    if (!chosen.remark.empty()) context.progress.note(chosen.remark);
    Scene scene = chosen.scene;
    effects_.apply(scene);
    const auto anatomy =
        std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
    scene.motion = motion_to(pose, anatomy->jaw, is_video);
    const ContractionTrack track =
        sample_motion(scene.motion, muscles_used(scene.motion, anatomy->muscle_names()));

    Simulator face = make_simulator(scene, anatomy);
    FaceFilm film(anatomy,
                  face.lattice(),
                  track,
                  is_video ? output_ : "",
                  is_video ? "" : output_,
                  animation_.animate_options());
    context.progress.begin(name(), static_cast<int>(track.frames.size()));
    const auto take = [&](int frame, const FaceState& state, const MotionRow& row) {
      film.take(frame, state, row.rms_mm);
      context.progress.update(frame + 1);
    };
    const Simulation simulation = simulate_scene(face, track, take, context.stop);
    context.progress.end();
    film.finish();
    if (scene.tissue.lattice.topology == Topology::kPrisms) warn_of_folds(face, pose, context);
    print_summary(simulation, context);
    const std::string verdict = face_.verdict(simulation.frame_ms());
    if (!verdict.empty()) context.progress.note(verdict);
    return 0;
  }

 private:
  // A still has one frame; a video rises, rests and returns.
  Motion motion_to(const Pose& pose, const Jaw& jaw, bool is_video) const {
    constexpr double kRise_s = 0.7;
    constexpr double kHold_s = 0.5;
    constexpr double kRest_s = 0.2;
    MotionKey key{0.0, std::max(pose.jaw, jaw_deg_ * kDegree / jaw.full_rad), pose.contraction};
    Motion motion;
    if (!is_video) {
      motion.keys = {key};
      return motion;
    }
    double time_s = 0.0;
    const auto add = [&](const MotionKey& at, double after_s) {
      motion.keys.push_back(at);
      motion.keys.back().time_s = time_s += after_s;
    };
    const MotionKey neutral;
    add(neutral, 0.0);
    add(neutral, kRest_s);
    add(key, kRise_s);
    add(key, kHold_s);
    add(neutral, kRise_s);
    add(neutral, kRest_s);
    return motion;
  }

  // Contractions that are fine one by one may ask together for what tissue cannot do.
  static void warn_of_folds(const Simulator& face, const Pose& pose, RunContext& context) {
    const Anatomy& anatomy = face.anatomy();
    const MuscleField field = make_muscle_field(anatomy, face.lattice());
    const int folded = num_folded(anatomy, field, controls_of(pose, anatomy).contraction);
    if (folded == 0) return;
    context.progress.note("these contractions together ask skin to fold over in " +
                          std::to_string(folded) + " places");
  }

  void print_summary(const Simulation& simulation, RunContext& context) const {
    double largest_mm = 0.0;
    for (const MotionRow& row : simulation.rows) largest_mm = std::max(largest_mm, row.largest_mm);
    if (simulation.frames_not_converged() > 0) {
      context.progress.note("the face did not settle fully; worst residual " +
                            shortest_text(simulation.worst_residual()) + " of the load");
    }
    if (simulation.most_inverted_elements() > 0) {
      context.progress.note(std::to_string(simulation.most_inverted_elements()) +
                            " tissue elements turned inside out");
    }
    char line[80];
    std::snprintf(line, sizeof line, "moves by up to %.1f mm: ", largest_mm);
    context.out << line << output_ << '\n';
  }

  std::string text_;
  std::string output_ = "expression.png";
  double jaw_deg_ = 0.0;
  std::string scene_path_;
  EffectOptions effects_;
  FaceOptions face_;
  AnimationOptions animation_;
};

}  // namespace

std::unique_ptr<Command> make_express_command() { return std::make_unique<ExpressCommand>(); }

}  // namespace zygoma
