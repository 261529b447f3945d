// zygoma tradeoff: what accuracy costs in time on this machine.
#include "src/pipeline/tradeoff.h"

#include <cstdio>
#include <fstream>
#include <ostream>

#include "src/cli/command.h"
#include "src/cli/session_parts.h"
#include "src/io/output_folder.h"
#include "src/io/scene_file.h"

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
    return "measure what accuracy of the tissue costs in time on this machine";
  }
  std::string details() const override {
    return "Simulates a motion with two or three layers, 300 to 2000 surface vertices, three "
           "tolerances and the explicit steps of 1992, and holds each against one reference of "
           "4000 "
           "vertices converged to 1e-6 of the load. Writes into the folder: tradeoff.csv, "
           "tradeoff.svg (error over time with the front: what nothing beats in both) and "
           "session.json with the machine. The levels of --quality are points of that front.";
  }
  std::string example() const override { return "-o result"; }
  int rank() const override { return 8; }
  void declare(OptionSink& options) override {
    options.text(
        "--scene",
        scene_path_,
        "FILE",
        "a scene whose head, effects and motion are used; without it a smile, raised brows "
        "and an opening jaw");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
  }

  int run(RunContext& context) override {
    Scene scene;
    if (scene_path_.empty()) {
      scene.motion = tradeoff_motion();
    } else {
      scene = read_scene(scene_path_);
    }
    const OutputFolder folder(folder_);
    const Tradeoff tradeoff = measure_tradeoff(
        scene, tissue_choices(), tissue_reference(), context.progress, context.stop);
    write_tradeoff_csv(folder / "tradeoff.csv", tradeoff);
    write_tradeoff_plot(folder / "tradeoff.svg", tradeoff);
    Session session = begin_session(name(), context);
    session.libraries.emplace_back("processor", processor_name());
    session.stopped_early = tradeoff.stopped;
    write_session(folder / "session.json", session);
    print(tradeoff, context.out);
    context.out << "error over time: " << folder / "tradeoff.svg" << '\n';
    return 0;
  }

 private:
  static void print(const Tradeoff& tradeoff, std::ostream& out) {
    out << "quality    layers  vertices  residual  ms per frame  error RMS  largest (front only)\n";
    for (const TradeoffRow& row : tradeoff.rows) {
      if (!row.on_front) continue;
      const FaceQuality& quality = row.choice.quality;
      char line[160];
      std::snprintf(line,
                    sizeof line,
                    "%-10s %6d %9d %9.0e %13.2f %7.3f mm %5.2f mm\n",
                    row.choice.name.c_str(),
                    quality.bi_layer ? 2 : 3,
                    quality.surface_vertices,
                    quality.relative_residual,
                    row.frame_ms,
                    row.rms_mm,
                    row.largest_mm);
      out << line;
    }
    char line[80];
    std::snprintf(line, sizeof line, "reference  %52.2f\n", tradeoff.reference_ms);
    out << line;
  }

  std::string scene_path_;
  std::string folder_ = "zygoma-out";
};

}  // namespace

std::unique_ptr<Command> make_tradeoff_command() { return std::make_unique<TradeoffCommand>(); }

}  // namespace zygoma
