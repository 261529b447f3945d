// retarget_report.json and contractions.svg: why the contractions are what they are
// (docs/formats.md).
#pragma once

#include <string>

#include "retarget/review.h"

namespace zygoma {

// Both throw InputError naming the file when it cannot be written.
void write_retarget_report(const std::string& path,
                           const RetargetReview& review,
                           const RetargetReport& report);

// Every pair of muscles and the jaw over time, left and right, with bands of two sigma; `smooth`
// (may be null) as dashes.
void write_contraction_plot(const std::string& path,
                            const ContractionTrack& track,
                            const ContractionTrack* smooth);

}  // namespace zygoma
