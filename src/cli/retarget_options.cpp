#include "src/cli/retarget_options.h"

#include <limits>

namespace zygoma {

void RetargetingOptions::declare(OptionSink& options) {
  options.integer(
      "--neutral",
      neutral_frame_,
      {-1, std::numeric_limits<int>::max()},
      "number of a frame that shows the face at rest; -1: the stillest stretch of the clip");
  options.flag("--closed-form",
               closed_form_,
               "only the closed-form estimates, without the refinement against the face model: "
               "quick, coarse");
}

Retargeted RetargetingOptions::retarget(const std::vector<ContourSet>& contours,
                                        const FaceResponse& response,
                                        Simulator& lattice,
                                        RunContext& context) const {
  RetargetOptions options;
  options.neutral_frame = neutral_frame_;
  options.refine = !closed_form_;
  Retargeted result;
  context.progress.begin("retarget", static_cast<int>(contours.size()));
  const Stopwatch watch;
  // The stage asks once per frame whether to stop, which is also the moment to say how far it is.
  int num_asked = 0;
  const StopQuestion stop = [&] {
    context.progress.update(num_asked++);
    return context.stop();
  };
  result.track =
      zygoma::retarget(contours, {response, &lattice, nullptr}, options, result.report, stop);
  context.progress.update(static_cast<int>(result.track.frames.size()));
  context.progress.end();
  result.figures = {"retarget", static_cast<int>(result.track.frames.size()), watch.elapsed_ms()};
  return result;
}

}  // namespace zygoma
