// Options of the commands that turn contours into contractions.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "retarget/retarget.h"
#include "retarget/smooth.h"
#include "src/cli/command.h"
#include "src/io/output_folder.h"
#include "src/pipeline/run_quality.h"
#include "src/pipeline/stage_figures.h"

namespace zygoma {

struct Retargeted {
  ContractionTrack track;
  std::optional<ContractionTrack> smooth;
  RetargetReport report;
  StageFigures figures;
  std::vector<std::string> remarks;  // about neutral and profile

  // What an animation shows: the filtered curves where they were asked for.
  const ContractionTrack& shown() const { return smooth ? *smooth : track; }
};

class RetargetingOptions {
 public:
  void declare(OptionSink& options);
  // Reads the profile, if one is given. Throws InputError about it or about options that
  // contradict each other; before long work begins.
  void prepare();
  // Throws InputError where an option is given that `who` decides.
  void leave_quality_to(const std::string& who) const;
  // The level where it is not given.
  void set_usual(const RunQuality& quality);
  // As the options say.
  RetargetOptions estimation() const;
  const PerformerProfile* profile() const { return profile_ ? &*profile_ : nullptr; }

  // `lattice` is the face that the response is of.
  Retargeted retarget(const std::vector<ContourSet>& contours,
                      const FaceResponse& response,
                      Simulator& lattice,
                      RunContext& context) const;
  // contractions.csv, contractions_filtered.csv, retarget_report.json, contractions.svg, and the
  // profile where it is asked for.
  void write(const Retargeted& result, const OutputFolder& folder) const;

 private:
  std::vector<std::string> remarks_on(const RetargetReport& report) const;

  int neutral_frame_ = -1;
  std::string method_ = "refined";
  std::string level_ = "auto";
  RunQuality usual_ = run_quality("standard");
  std::string smoothing_ = "none";
  bool live_ = false;
  double focal_length_px_ = 0.0;
  std::string profile_path_;
  std::string save_profile_path_;
  std::optional<PerformerProfile> profile_;
};

}  // namespace zygoma
