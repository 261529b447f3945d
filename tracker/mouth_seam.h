// Where the dark seam between the lips ends: a second opinion on the corners of the mouth.
//
// The border of the lips fades towards the corners, and optical flow slides along it; the seam does
// not fade before the corner. It is followed outwards from within the mouth as the strongest dark
// line (positive second difference of brightness across it), and the corner is put where its
// strength steps down most: the matched filter of a step, mean strength of the last 16 pixels less
// that of the next 12. Shorter windows catch on the bright spot where a mouth that opens tears the
// seam apart, or on a gap in it. A crease beyond the corner prolongs the seam by about the same
// length in every frame, so only changes of the end count: its usual distance is what the first
// frame says, improved by a running mean.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

enum MouthSide : size_t { kRightCorner, kLeftCorner, kNumCorners };
using MouthCorners = std::array<Point2, kNumCorners>;  // chart px

// The ends of the seam; `corners` are where the corners are thought to be. A side without a seam
// keeps its corner.
MouthCorners find_seam_ends(const cv::Mat& grey, const MouthCorners& corners);

// The corners moved towards the ends of the seam, and what is usual between the two.
class SeamCorners {
 public:
  MouthCorners refine(const cv::Mat& grey, const MouthCorners& corners);
  void forget() { *this = SeamCorners(); }

 private:
  MouthCorners usual_px_{Point2::Zero(), Point2::Zero()};  // seam end less corner
  int frames_ = 0;
};

}  // namespace zygoma
