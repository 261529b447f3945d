// Levels of quality of a whole run: what the tracker, the estimation and the tissue do at each,
// points of the front that quality_bench measures (docs/accuracy-and-time.md).
//
// A level says which face is drawn and which one the estimation asks for its response, as a face
// that is worth drawing may be too dear to be settled several times a frame.
#pragma once

#include <string>
#include <vector>

#include "face/quality.h"
#include "retarget/retarget.h"
#include "src/pipeline/track_video.h"

namespace zygoma {

struct RunQuality {
  std::string name;
  FaceQuality face;        // settled and drawn
  FaceQuality estimation;  // asked how contours respond
  SecondLooks second_looks = SecondLooks::kStart;
  FaceLevel level = FaceLevel::kCorrected;
  int samples_per_pixel = 2;  // of the drawing, at edges
  // As measured (docs/results/run_quality.csv) on the sample clip, whose truth is known: RMS over
  // muscles and frames. It does not fall beyond `standard`: there only the skin comes closer.
  double expected_contraction_rms = 0.0;
  // There, too: to get ready, and per frame without the tracking. A first guess for another
  // machine, nothing more.
  double about_start_ms = 0.0;
  double about_frame_ms = 0.0;

  void apply(RetargetOptions& options) const;
  bool has_one_face() const;  // the one that is drawn is the one of the estimation
};

// From the quickest to the one with the most accurate skin; those between draft, standard, fine and
// reference are for budgets and tolerances.
const std::vector<RunQuality>& run_qualities();

// Throws InputError naming the choices if there is none of that name.
const RunQuality& run_quality(const std::string& name);

}  // namespace zygoma
