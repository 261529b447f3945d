// Curves without jitter, beside the raw ones and never in their place.
//
// For files without delay: every value becomes that of a parabola fitted to its neighbourhood in
// time (local quadratic regression; Savitzky and Golay's filter for uneven steps and uneven
// trust), weights w = exp(-(dt / width)^2 / 2) / sigma^2, so that frames that coast do not pull
// good ones. For live use the One-Euro filter (Casiez, Roussel and Vogel 2012), causal:
//
//   x' = x'_last + a (x - x'_last),   a = 1 / (1 + tau / step),  tau = 1 / (2 pi cutoff),
//   cutoff = lowest + beta |speed|,   the speed filtered likewise.
#pragma once

#include <string>
#include <vector>

#include "face/contractions.h"

namespace zygoma {

// What a filter is for: curves to look at or to edit (stable), the usual, fast speech (responsive).
enum class SmoothIntent { kResponsive, kBalanced, kStable };

const std::vector<std::string>& smooth_intent_names();
// Throws InputError for a word that is none of these.
SmoothIntent parse_smooth_intent(const std::string& name);

double smoothing_width_s(SmoothIntent intent);

// Values, jaw and head; frames without estimate stay empty and lend nothing.
ContractionTrack smooth_track(const ContractionTrack& track, SmoothIntent intent);

struct OneEuroOptions {
  double lowest_cutoff_hz = 1.0;  // small: less jitter at rest, more delay
  double beta = 0.0;              // large: less delay of fast motion, more jitter in it
  double speed_cutoff_hz = 1.0;
};

OneEuroOptions one_euro_options(SmoothIntent intent);

// One signal.
class OneEuro {
 public:
  explicit OneEuro(const OneEuroOptions& options) : options_(options) {}

  double operator()(double value, double time_s);

 private:
  OneEuroOptions options_;
  bool has_last_ = false;
  double last_time_s_ = 0.0;
  double value_ = 0.0;
  double speed_ = 0.0;
};

// The same for a whole track, frame by frame in order; what a live performance would have seen.
ContractionTrack smooth_track_live(const ContractionTrack& track, SmoothIntent intent);

}  // namespace zygoma
