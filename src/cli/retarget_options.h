// Options of the commands that turn contours into contractions.
#pragma once

#include <utility>
#include <vector>

#include "retarget/retarget.h"
#include "src/cli/command.h"
#include "src/pipeline/stage_figures.h"

namespace zygoma {

struct Retargeted {
  ContractionTrack track;
  RetargetReport report;
  StageFigures figures;
};

class RetargetingOptions {
 public:
  void declare(OptionSink& options);
  // `lattice` is the face that the response is of.
  Retargeted retarget(const std::vector<ContourSet>& contours,
                      const FaceResponse& response,
                      Simulator& lattice,
                      RunContext& context) const;

 private:
  int neutral_frame_ = -1;
  bool closed_form_ = false;
};

}  // namespace zygoma
