// From contours to contractions: head frame out, the paper's closed-form estimates (section 6c) as
// first guess, then a bounded least-squares refinement (Ceres) against the face model's own
// response, frame by frame as a live performance asks for, and for files once more in windows.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "face/contractions.h"
#include "retarget/lattice_loop.h"
#include "retarget/observe.h"
#include "retarget/profile.h"
#include "retarget/refine.h"
#include "retarget/response.h"
#include "tracker/contour_set.h"

namespace zygoma {

// What the refinement takes for the face: the baked linear response, the response with saturation
// and pairwise correctives, or the equilibrium of the lattice itself.
enum class FaceLevel { kLinear, kCorrected, kLattice };

struct RetargetOptions {
  int neutral_frame = -1;  // -1: the profile's, or found as the stillest stretch at rest
  bool refine = true;      // false: the paper's closed-form estimates alone
  bool causal = false;     // true: no frame knows those after it, as in a live performance
  FaceLevel level = FaceLevel::kCorrected;
  double focal_length_px = 0.0;  // of the performer's camera; 0: unknown, as far away as
                                 // the one the response was measured with
  ObservationOptions observation;
  RefineOptions refinement;
  LatticeLoopOptions lattice_loop;

  void check() const;
};

// What the estimation works with. The simulator is that of the response, for FaceLevel::kLattice.
struct FaceModel {
  const FaceResponse& response;
  Simulator* lattice = nullptr;
  const PerformerProfile* profile = nullptr;
};

// One frame beyond its contractions, for those who ask why.
struct FrameInsight {
  int frame_index = 0;
  bool converged = false;
  double cost = 0.0;          // what is left of the least squares, priors included
  double optimality = 0.0;    // largest gradient left (Karush, Kuhn, Tucker)
  Eigen::MatrixXd influence;  // controls x contours (FramePosterior)
};

struct RetargetReport {
  int neutral_frame = -1;  // of the clip; -1: from the profile
  std::vector<std::string> neutral_doubts;
  double profile_difference = 0.0;  // of the proportions of the face, clip against profile
  double jaw_carry = 1.0;           // of the corners of the mouth, times the model's (jaw_carry.h)
  double face_unit_px = 0.0;        // the unit of displacements in the neutral frame
  double millimetre_per_px = 0.0;   // at the neutral frame, assuming the model's proportions
  int frames_estimated = 0;
  int frames_not_converged = 0;
  int response_not_converged = 0;  // settles of the face while its response was measured
  LatticeLoopFigures lattice;
  double median_residual_px = 0.0;
  PerformerProfile performer;          // as this clip shows it
  std::vector<FrameInsight> insights;  // of the frames that were refined
};

// Asked now and then, with the share of the work that is done: should it stop?
using RetargetQuestion = std::function<bool(double done)>;

// One Contractions per ContourSet, muscles named as in the anatomy. Frames without contours have
// empty values and success = false. Throws InputError when no frame has contours. When `stop` says
// so, the track ends with the frames done by then.
//
// confidence and success speak of the contours that drive the estimate in every frame
// (driving_confidence()).
ContractionTrack retarget(const std::vector<ContourSet>& contours,
                          const FaceModel& face,
                          const RetargetOptions& options,
                          RetargetReport& report,
                          const RetargetQuestion& stop = {});

}  // namespace zygoma
