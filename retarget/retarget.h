// From contours to contractions: head frame out, the paper's closed-form estimates (section 6c) as
// first guess, then a Ceres refinement with bounds [0, 1] against the face model's own response.
#pragma once

#include <vector>

#include "face/contractions.h"
#include "retarget/response.h"
#include "src/base/stop.h"
#include "tracker/contour_set.h"

namespace zygoma {

struct RetargetOptions {
  int neutral_frame = -1;  // -1: found as the stillest stretch with a face at rest
  bool refine = true;      // false: the paper's closed-form estimates alone

  void check() const;
};

struct RetargetReport {
  int neutral_frame = -1;
  double face_unit_px = 0.0;       // the unit of displacements in the neutral frame
  double millimetre_per_px = 0.0;  // at the neutral frame, assuming the model's proportions
  int frames_estimated = 0;
  int frames_not_converged = 0;
  int response_not_converged = 0;  // settles of the face while its response was measured
  double median_residual_px = 0.0;
};

// One Contractions per ContourSet, muscles named as in the anatomy. Frames without contours have
// empty values and success = false. Throws InputError when no frame has contours. When `stop` says
// so, the track ends with the frames done by then.
//
// confidence and success speak of the contours that drive the estimate in every frame: brows, upper
// lip, chin boss and the better one of hairline and nose tip. The furrows do not count, as they
// vanish from a face at rest.
ContractionTrack retarget(const std::vector<ContourSet>& contours,
                          const FaceResponse& face,
                          const RetargetOptions& options,
                          RetargetReport& report,
                          const StopQuestion& stop = {});

}  // namespace zygoma
