// How close a result came to a known truth: contractions per muscle, contours per feature.
#pragma once

#include <string>
#include <vector>

#include "face/contractions.h"
#include "tracker/contour_set.h"

namespace zygoma {

struct ContractionError {
  std::string control;       // a muscle, or "jaw"
  double rms = 0.0;          // over frames with a value in both
  double correlation = 0.0;  // Pearson; 0 where the truth hardly moves
  double truth_range = 0.0;  // largest minus smallest true value
  int num_frames = 0;
};

// One row per muscle of the truth that the estimate has too, and the jaw; frames joined by index.
std::vector<ContractionError> compare_contractions(const ContractionTrack& estimate,
                                                   const ContractionTrack& truth);

struct ContourError {
  std::string contour;
  double median_px = 0.0;  // over frames, of the mean distance from node to the true polyline
  double p90_px = 0.0;
  // The same with the median of each node over the clip taken off its distance: the edge that is
  // followed and the line that is true need not be the same line, but they should move alike.
  double motion_median_px = 0.0;
  double motion_p90_px = 0.0;
  double cover = 0.0;  // share of true contours that have an estimate
};

std::vector<ContourError> compare_contours(const std::vector<ContourSet>& estimate,
                                           const std::vector<ContourSet>& truth);

// Over all controls, each counting alike.
double overall_rms(const std::vector<ContractionError>& errors);

// Plain-text tables.
std::string contraction_table(const std::vector<ContractionError>& errors);
std::string contour_table(const std::vector<ContourError>& errors);

}  // namespace zygoma
