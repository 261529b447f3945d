// Which level of quality fits a budget of time: the levels are tried on a piece of the motion
// itself, on the machine at hand.
#pragma once

#include <string>

#include "face/contractions.h"
#include "face/quality.h"

namespace zygoma {

struct QualityPick {
  FaceQuality quality;
  double expected_ms = 0.0;  // per frame, of processor time; above the budget where not even the
                             // quickest fits
};

// The most accurate level that settles a frame of the track in budget_ms on average, with the
// effects of the tissue. Levels are tried from the quickest on, over three stretches of the track,
// until one is too slow.
QualityPick pick_for_budget(double budget_ms,
                            const ContractionTrack& track,
                            const Identity& identity,
                            const TissueModel& tissue);

// The quickest level whose skin is expected to be within tolerance_mm (RMS) of the reference; the
// reference itself if none is.
QualityPick pick_for_tolerance(double tolerance_mm);

// What is said beforehand and afterwards of a time and its budget, by the same measure:
//   "the budget of 20 ms probably cannot be met, 7 % over", or nothing where it can;
//   "the budget is 20 ms: met" or "... not met, 7 % over" or "... not met, 3.2 times as long".
std::string budget_forecast(double expected_ms, double budget_ms);
std::string budget_verdict(double took_ms, double budget_ms);

}  // namespace zygoma
