// zygoma retarget: contours.csv in, contractions.csv out.
#include <ostream>

#include "retarget/measure_response.h"
#include "src/cli/command.h"
#include "src/cli/face_options.h"
#include "src/cli/retarget_options.h"
#include "src/cli/session_parts.h"
#include "src/io/contours_file.h"
#include "src/io/output_folder.h"

namespace zygoma {
namespace {

class RetargetCommand : public Command {
 public:
  std::string name() const override { return "retarget"; }
  std::string help() const override { return "turn contours into muscle contractions"; }
  std::string details() const override {
    return "Writes into the folder: contractions.csv (muscles and jaw in every frame, 0 to 1, with "
           "standard deviations and residuals), contractions.svg (the same as curves), "
           "retarget_report.json (how well the contours are met, which contour explains what, "
           "frames to look at) and session.json (options, versions, times).";
  }
  std::string example() const override { return "result/contours.csv -o result"; }
  int rank() const override { return 3; }
  void declare(OptionSink& options) override {
    options.positional("CONTOURS", contours_path_, "contours.csv of `zygoma track`");
    options.text("-o,--output", folder_, "FOLDER", "where the results go; made if missing");
    retargeting_.declare(options);
    face_.declare(options);
  }
  int run(RunContext& context) override {
    retargeting_.prepare();
    const std::vector<ContourSet> contours = read_contours_csv(contours_path_);
    const OutputFolder folder(folder_);
    AssembledFace face = face_.assemble();
    const Retargeted result =
        retargeting_.retarget(contours, measure_response(face.simulator), face.simulator, context);
    retargeting_.write(result, folder);

    Session session = begin_session(name(), context);
    session.source.file = contours_path_;
    session.source.num_frames = static_cast<int>(contours.size());
    session.muscles = result.track.muscles;
    session.neutral_frame = result.report.neutral_frame;
    session.stopped_early = result.track.frames.size() < contours.size();
    session.stages.push_back(stage_of(result.report, result.figures));
    write_session(folder / "session.json", session);
    for (const std::string& remark : result.remarks) context.progress.note(remark);
    for (const std::string& remark : remarks(result.report)) context.progress.note(remark);
    context.out << result.track.frames.size()
                << " frames estimated: " << folder / "contractions.csv" << '\n';
    return 0;
  }

 private:
  std::string contours_path_;
  std::string folder_ = "zygoma-out";
  RetargetingOptions retargeting_;
  FaceOptions face_;
};

}  // namespace

std::unique_ptr<Command> make_retarget_command() { return std::make_unique<RetargetCommand>(); }

}  // namespace zygoma
