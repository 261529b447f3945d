// zygoma effects: what may act on the tissue, and why a scene's effects acted when they did.
#include <optional>
#include <ostream>

#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/cli/effect_options.h"
#include "src/io/output_folder.h"
#include "src/io/scene_file.h"
#include "src/pipeline/explain_effects.h"

namespace zygoma {
namespace {

class EffectsCommand : public Command {
 public:
  std::string name() const override { return "effects"; }
  std::string help() const override {
    return "list the effects on the tissue, or explain those of a scene";
  }
  std::string details() const override {
    return "Without --explain: every effect in a sentence, with its parameters. With it the scene "
           "is run as it says, with everything in every frame, and without each of its effects; "
           "then for each: in which frames it acted, what it costs per frame, how far the face is "
           "elsewhere without it, and why it acted. With -o that is written into the folder, too: "
           "effects.csv.";
  }
  std::string example() const override { return "--explain samples/two_minutes.json -o result"; }
  int rank() const override { return 7; }
  void declare(OptionSink& options) override {
    options.text("--explain", scene_path_, "SCENE", "a scene file (JSON, docs/formats.md)");
    effects_.declare_choice(options);
    options.text("-o,--output", folder_, "FOLDER", "where effects.csv goes; made if missing");
  }

  int run(RunContext& context) override {
    if (scene_path_.empty()) {
      require(folder_.empty(), "-o: goes with --explain");
      list(context.out);
      return 0;
    }
    Scene scene = read_scene(scene_path_);
    effects_.apply(scene);
    const auto anatomy =
        std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
    const ContractionTrack track = sample_motion(scene.motion, anatomy->muscle_names());
    std::optional<OutputFolder> folder;
    if (!folder_.empty()) folder.emplace(folder_);
    const Explanation explanation =
        explain_effects(scene, anatomy, track, context.progress, context.stop);
    if (folder) write_effect_stories_csv(*folder / "effects.csv", explanation.stories);
    context.out << explanation_table(explanation);
    return 0;
  }

 private:
  static void list(std::ostream& out) {
    for (const Effect& effect : all_effects()) {
      out << effect.name << ": " << effect.what << '\n';
      if (!effect.called_for_when.empty()) {
        out << "  by itself, with \"effects\": \"auto\", when " << effect.called_for_when << '\n';
      }
      for (const EffectParameter& p : effect.parameters) {
        out << "  " << p.name << " = " << shortest_text(p.usual) << " (" << shortest_text(p.lowest)
            << " to " << shortest_text(p.highest) << "): " << p.help << '\n';
      }
    }
  }

  std::string scene_path_;
  std::string folder_;
  EffectOptions effects_;
};

}  // namespace

std::unique_ptr<Command> make_effects_command() { return std::make_unique<EffectsCommand>(); }

}  // namespace zygoma
