// zygoma face: what the face can do, as a list or as a picture of everything.
#include <cstdio>
#include <ostream>

#include "face/facs.h"
#include "face/muscle_table.h"
#include "src/base/names.h"
#include "src/cli/command.h"
#include "src/cli/face_options.h"
#include "src/io/output_folder.h"
#include "src/io/picture_file.h"
#include "src/pipeline/contact_sheet.h"

namespace zygoma {
namespace {

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

// "corrugator_supercilii, procerus 0.6, jaw 0.35"
std::string parts_of(const ActionUnit& unit) {
  std::string text;
  const auto add = [&](const std::string& what, double weight) {
    text += (text.empty() ? "" : ", ") + what;
    if (weight < 1.0) text.append(" ").append(two_digits(weight));
  };
  for (const ActionPull& pull : unit.pulls) add(pull.muscle, pull.weight);
  if (unit.jaw > 0.0) add("jaw", unit.jaw);
  return text;
}

std::string pulls_of(const Pose& pose) {
  std::string text;
  for (const auto& [muscle, value] : pose.contraction) {
    text += (text.empty() ? "" : ",") + muscle + "=" + two_digits(value);
  }
  return text;
}

void list_muscles(std::ostream& out) {
  for (const std::string& name : standard_muscle_names()) out << name << '\n';
}

void list_units(std::ostream& out) {
  for (const ActionUnit& unit : action_units()) {
    char head[64];
    std::snprintf(head, sizeof head, "%2d  %-22s %-14s", unit.number, unit.name, unit.group);
    out << head << parts_of(unit) << '\n';
  }
}

void list_expressions(std::ostream& out) {
  for (const Expression& expression : expressions()) {
    char head[32];
    std::snprintf(head, sizeof head, "%-18s ", expression.name.c_str());
    const bool by_units = !expression.units.empty();
    out << head << (by_units ? expression.units : pulls_of(expression.pose)) << '\n';
  }
}

class FaceCommand : public Command {
 public:
  std::string name() const override { return "face"; }
  std::string help() const override { return "list what the face can do, or picture all of it"; }
  std::string details() const override {
    return "`zygoma face list muscles`, `aus` or `expressions` prints the names that `express` and "
           "keyframes take; without a word, all three. `zygoma face sheet -o sheet.png` draws "
           "every action unit and every expression.";
  }
  std::string example() const override { return "sheet -o sheet.png"; }
  int rank() const override { return 6; }
  void declare(OptionSink& options) override {
    options.positional("WHAT", what_, "list or sheet");
    options.optional_positional("KIND", kind_, "of a list: muscles, aus or expressions");
    options.text("-o,--output", output_, "FILE", "the picture of a sheet (.png, .jpg)");
    options.integer("--tile", tile_px_, {64, 1024}, "height of one face on a sheet, pixels");
    options.integer("--columns", num_columns_, {1, 40}, "of a sheet");
    options.text(
        "--scene", scene_path_, "FILE", "head, tissue, effects and solver of a scene file");
    face_.declare(options);
  }

  int run(RunContext& context) override {
    if (what_ == "list") return list(context);
    if (what_ == "sheet") return sheet(context);
    throw InputError(quote_value(what_) + ": expected list or sheet");
  }

 private:
  int list(RunContext& context) const {
    const bool all = kind_.empty();
    require(all || kind_ == "muscles" || kind_ == "aus" || kind_ == "expressions",
            quote_value(kind_) + ": expected muscles, aus or expressions");
    if (all) context.out << "muscles (0 to 1 each):\n";
    if (all || kind_ == "muscles") list_muscles(context.out);
    if (all) context.out << "\naction units and the muscles they contract:\n";
    if (all || kind_ == "aus") list_units(context.out);
    if (all) context.out << "\nexpressions:\n";
    if (all || kind_ == "expressions") list_expressions(context.out);
    return 0;
  }

  int sheet(RunContext& context) const {
    require(kind_.empty(), quote_value(kind_) + ": a sheet shows everything, expected nothing");
    require_picture_name(output_);
    if (!scene_path_.empty()) require_not_the_input(output_, scene_path_);
    const Scene scene = face_.scene(scene_path_).scene;
    const auto anatomy =
        std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
    std::vector<SheetEntry> entries;
    for (const Expression& expression : expressions()) {
      entries.push_back({expression.name, expression.units, expression.pose});
    }
    for (const ActionUnit& unit : action_units()) {
      std::string number(unit.one_sided ? "L" : "");
      number += std::to_string(unit.number);
      entries.push_back({"AU " + number, unit.name, pose_of_action_units(number)});
    }
    SheetOptions options;
    options.tile_height_px = tile_px_;
    options.num_columns = num_columns_;
    SheetReport report;
    const cv::Mat picture =
        contact_sheet(scene, anatomy, entries, options, report, context.progress, context.stop);
    if (!report.not_converged.empty()) {
      context.progress.note("not fully settled: " + joined_names(report.not_converged));
    }
    if (!report.inverted.empty()) {
      context.progress.note("tissue elements inside out: " + joined_names(report.inverted));
    }
    write_picture(output_, picture);
    context.out << entries.size() << " faces: " << output_ << '\n';
    return 0;
  }

  std::string what_;
  std::string kind_;
  std::string output_ = "sheet.png";
  std::string scene_path_;
  int tile_px_ = 240;
  int num_columns_ = 8;
  FaceOptions face_;
};

}  // namespace

std::unique_ptr<Command> make_face_command() { return std::make_unique<FaceCommand>(); }

}  // namespace zygoma
