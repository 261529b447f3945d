// Where the chin is: a large patch of skin found again by normalised cross-correlation.
//
// The chin has no edge worth the name and too little texture for the flow of single points, but as
// a whole (boss, jaw line, the shading under the lip) it looks the same wherever the jaw carries
// it. So the patch seen at the start is looked for in every frame, coarsely over the whole range of
// the jaw and then to a fraction of a pixel. Measured against the start, it cannot drift.
#pragma once

#include <opencv2/core.hpp>

#include "tracker/contour_set.h"

namespace zygoma {

class ChinPatch {
 public:
  struct Sight {
    Point2 offset_px = Point2::Zero();  // of the chin since it was learned
    double likeness = 0.0;              // correlation, [-1, 1]; 0 where nothing was learned
  };

  // `chin` is the middle of the chin boss; chart px.
  void learn(const cv::Mat& grey, const Point2& chin);
  Sight find(const cv::Mat& grey) const;

 private:
  cv::Rect place_;
  cv::Mat patch_;        // 8-bit
  cv::Mat small_patch_;  // at half the resolution
};

}  // namespace zygoma
