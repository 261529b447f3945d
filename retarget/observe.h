// A tracked frame as the estimation sees it: carried into the performer's neutral head frame by a
// first guess of the head's motion, in millimetres of the model, every contour with the sigma that
// its confidence deserves.
#pragma once

#include "retarget/calibration.h"
#include "retarget/estimate.h"
#include "retarget/head_motion.h"
#include "retarget/refine.h"

namespace zygoma {

struct ObservationOptions {
  double noise_px = 0.5;        // of a sure contour across itself; [0, 100]
  double model_error_mm = 0.3;  // how far one person's skin moves unlike another's; [0, 100]; the
                                // two together are at least 1e-4 mm
  void check() const;
};

struct FrameReading {
  HeadMotion head;  // neutral px to frame px, from the rigid contours
  FrameObservation observation;
  Displacements displacements;
};

inline constexpr double kLeastConfidence = 0.1;  // below: as good as lost

// Sigma of a contour in mm; 0 where its confidence is too low to be evidence.
double contour_sigma_mm(int contour,
                        double confidence,
                        double millimetre_per_px,
                        const ObservationOptions& options);

FrameReading read_frame(const ObservedFrame& frame,
                        const Neutral& neutral,
                        const PerformerFrame& performer,
                        const ObservationOptions& options);

// Whether a frame shows enough of the face to be estimated at all.
bool is_usable(const StackedContours& contours);

// Smallest confidence over the contours that drive something: brows, upper lip, chin boss and the
// best of those that show the head. The furrows do not count, as they vanish from a face at rest.
double driving_confidence(const StackedContours& contours);

}  // namespace zygoma
