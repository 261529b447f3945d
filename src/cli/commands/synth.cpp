// zygoma synth: a performer whose contractions are known, with the truth beside the video.
#include <limits>
#include <ostream>

#include "src/base/check.h"
#include "src/cli/command.h"
#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/output_folder.h"
#include "src/io/video_writer.h"
#include "src/synthetic/performer.h"

namespace zygoma {
namespace {

class SynthCommand : public Command {
 public:
  std::string name() const override { return "synth"; }
  std::string help() const override {
    return "film a synthetic performer whose contractions and contours are known";
  }
  std::string details() const override {
    return "Writes into the folder: NAME.mp4, NAME.contractions.csv and NAME.contours.csv, the "
           "last "
           "two being the truth to compare with (`zygoma run --truth`, `--truth-contours`).";
  }
  std::string example() const override { return "-o performer --schedule smile --duration 3"; }
  int rank() const override { return 5; }
  void declare(OptionSink& options) override {
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    options.text("--name", name_, "NAME", "files are NAME.mp4, NAME.contractions.csv, ...");
    options.integer("--seed",
                    seed_,
                    {0, std::numeric_limits<int>::max()},
                    "person, light, head sway and noise all come from it");
    options.choice("--schedule",
                   performer_.schedule,
                   {"mixed", "surprise", "smile", "speech", "neutral"},
                   "what the performer does");
    options.number("--duration", performer_.duration_s, {0.1, 600.0}, "seconds");
    options.number("--rate", performer_.frames_per_s, {5.0, 120.0}, "frames per second");
    options.integer("--width", performer_.width_px, {64, 3840}, "pixels");
    options.integer("--height", performer_.height_px, {64, 2160}, "pixels");
    options.number("--noise",
                   performer_.noise_grey_levels,
                   {0.0, 40.0},
                   "standard deviation of the camera noise in grey levels");
    options.number(
        "--sway", performer_.sway, {0.0, 3.0}, "amount of head motion; 0: the head is still");
    options.integer("--crf",
                    encoding_.constant_rate_factor,
                    {0, 51},
                    "H.264 quality: 18 looks perfect, every 6 more halve the file");
  }
  int run(RunContext& context) override {
    require(!name_.empty() && name_.find('/') == std::string::npos,
            "--name: '" + name_ + "', expected the name of a file without its folder");
    const OutputFolder folder(folder_);
    performer_.seed = static_cast<std::uint32_t>(seed_);
    performer_.check();
    encoding_.preset = "slow";
    Performer performer(performer_);
    VideoWriter writer(folder / (name_ + ".mp4"),
                       performer_.width_px,
                       performer_.height_px,
                       performer_.frames_per_s,
                       encoding_);
    ContractionTrack truth;
    truth.muscles = performer.muscles();
    std::vector<ContourSet> true_contours;
    context.progress.begin("synth", performer.num_frames());
    Frame frame;
    Contractions contractions;
    ContourSet contours;
    while (performer.next(frame, contractions, contours)) {
      writer.write(frame.image, frame.time_s);
      truth.frames.push_back(contractions);
      true_contours.push_back(contours);
      context.progress.update(static_cast<int>(truth.frames.size()));
      if (context.stop()) break;
    }
    writer.finish();
    context.progress.end();
    write_contractions_csv(folder / (name_ + ".contractions.csv"), truth);
    write_contours_csv(folder / (name_ + ".contours.csv"), true_contours);
    context.out << truth.frames.size() << " frames: " << folder / (name_ + ".mp4") << '\n';
    return 0;
  }

 private:
  std::string folder_ = "zygoma-out";
  std::string name_ = "performer";
  int seed_ = 1;
  PerformerOptions performer_;
  VideoWriterOptions encoding_;
};

}  // namespace

std::unique_ptr<Command> make_synth_command() { return std::make_unique<SynthCommand>(); }

}  // namespace zygoma
