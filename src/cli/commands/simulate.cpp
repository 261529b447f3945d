// zygoma simulate: a scene file in, the motion of the tissue out.
#include <cstdio>
#include <optional>
#include <ostream>

#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/effect_options.h"
#include "src/cli/face_options.h"
#include "src/cli/session_parts.h"
#include "src/io/contractions_file.h"
#include "src/io/output_folder.h"
#include "src/io/picture_file.h"
#include "src/io/scene_file.h"
#include "src/pipeline/face_film.h"
#include "src/pipeline/simulate_scene.h"

namespace zygoma {
namespace {

SessionStage stage_of(const Simulation& simulation, const std::string& name) {
  const double frame_ms = simulation.frame_ms();
  const auto num_frames = static_cast<double>(simulation.rows.size());
  return {name,
          frame_ms * num_frames,
          frame_ms,
          {{"frames_not_converged", simulation.frames_not_converged()},
           {"worst_residual", simulation.worst_residual()},
           {"most_inverted_elements", simulation.most_inverted_elements()},
           {"largest_mean_volume_change", simulation.largest_volume_change()}}};
}

class SimulateCommand : public Command {
 public:
  std::string name() const override { return "simulate"; }
  std::string help() const override {
    return "run a scene: tissue, effects and motion from a file";
  }
  std::string details() const override {
    std::string text =
        "Writes into the folder: motion.csv (how every frame was solved and how far the face "
        "moved), contractions.csv (what drove it), session.json, and with --compare effects.csv. "
        "Effects:";
    for (const Effect& effect : all_effects())
      text += " " + effect.name + " (" + effect.what + ");";
    text.back() = '.';
    return text;
  }
  std::string example() const override {
    return "samples/smile.json -o result --with inertia --picture smile.png";
  }
  int rank() const override { return 7; }
  void declare(OptionSink& options) override {
    options.positional("SCENE", scene_path_, "a scene file (JSON, docs/formats.md)");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    effects_.declare_choice(options);
    options.flag("--simulate-all",
                 simulate_all_,
                 "every effect in every frame and all tissue, also where it hardly moves");
    options.flag("--compare",
                 compare_,
                 "run once more for each effect, with it or without, and say what it costs and "
                 "changes");
    options.text("--video", video_path_, "FILE", "a video of the face to write");
    options.text(
        "--picture", picture_path_, "FILE", "a picture to write, of the frame furthest from rest");
    animation_.declare(options);
  }

  int run(RunContext& context) override {
    Scene scene = read_scene(scene_path_);
    effects_.apply(scene);
    if (simulate_all_) scene.settle.still_mm = scene.settle.choose_mm = 0.0;
    if (!picture_path_.empty()) require_picture_name(picture_path_);
    for (const std::string& path : {video_path_, picture_path_}) {
      require_not_the_input(path, scene_path_);
    }
    const auto anatomy =
        std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
    const ContractionTrack track = sample_motion(scene.motion, anatomy->muscle_names());
    const OutputFolder folder(folder_);

    const Simulation simulation = simulate(scene, anatomy, track, context);
    write_motion_csv(folder / "motion.csv", simulation.rows);
    ContractionTrack done = track;
    done.frames.resize(simulation.rows.size());
    write_contractions_csv(folder / "contractions.csv", done);
    print_summary(simulation, context);
    bool stopped = simulation.stopped;
    if (compare_ && !stopped) {
      const std::vector<EffectRow> rows =
          compare_effects(scene, anatomy, track, simulation, context.progress, context.stop);
      write_effects_csv(folder / "effects.csv", rows);
      context.out << effect_table(rows);
      stopped = context.stop();
    }
    write_record(folder / "session.json", track, simulation, stopped, context);
    return 0;
  }

 private:
  Simulation simulate(const Scene& scene,
                      const std::shared_ptr<const Anatomy>& anatomy,
                      const ContractionTrack& track,
                      RunContext& context) const {
    // Bars only for muscles that do something.
    const ContractionTrack shown =
        sample_motion(scene.motion, muscles_used(scene.motion, track.muscles));
    Simulator face = make_simulator(scene, anatomy);
    std::optional<FaceFilm> film;
    if (!video_path_.empty() || !picture_path_.empty()) {
      film.emplace(
          anatomy, face.lattice(), shown, video_path_, picture_path_, animation_.animate_options());
    }
    context.progress.begin(name(), static_cast<int>(track.frames.size()));
    const auto take = [&](int frame, const FaceState& state, const MotionRow& row) {
      if (film) film->take(frame, state, row.rms_mm);
      context.progress.update(frame + 1);
    };
    Simulation simulation = simulate_scene(face, track, take, context.stop);
    context.progress.end();
    if (film) film->finish();
    return simulation;
  }

  void print_summary(const Simulation& simulation, RunContext& context) const {
    char line[200];
    std::snprintf(line,
                  sizeof line,
                  "%zu frames, %.2f ms per frame, worst residual %.1e, %d not converged, "
                  "%d inverted elements: ",
                  simulation.rows.size(),
                  simulation.frame_ms(),
                  simulation.worst_residual(),
                  simulation.frames_not_converged(),
                  simulation.most_inverted_elements());
    context.out << line << folder_ << '\n';
  }

  void write_record(const std::string& path,
                    const ContractionTrack& track,
                    const Simulation& simulation,
                    bool stopped,
                    const RunContext& context) const {
    Session session = begin_session(name(), context);
    session.source.file = scene_path_;
    session.source.num_frames = static_cast<int>(simulation.rows.size());
    session.source.time_from_container = false;
    session.muscles = track.muscles;
    session.stopped_early = stopped;
    session.stages.push_back(stage_of(simulation, name()));
    write_session(path, session);
  }

  std::string scene_path_;
  std::string folder_ = "zygoma-out";
  std::string video_path_;
  std::string picture_path_;
  bool simulate_all_ = false;
  bool compare_ = false;
  EffectOptions effects_;
  AnimationOptions animation_;
};

}  // namespace

std::unique_ptr<Command> make_simulate_command() { return std::make_unique<SimulateCommand>(); }

}  // namespace zygoma
