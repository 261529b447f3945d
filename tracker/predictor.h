// Where points of one chart have gone in another: pyramidal Lucas-Kanade flow, forward and
// backward.
//
// A point that does not come back to where it started was not seen in both pictures; its quality
// falls with the distance it misses by (and is zero where there was no texture to follow). The same
// call predicts from the last frame and re-anchors against an older one: only the chart differs.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

inline constexpr int kFlowWindow = 13;  // chart px: a fifth of the eye distance
inline constexpr int kFlowLevels = 2;   // pyramid levels above the finest

struct Flow {
  std::vector<Point2> points_px;
  std::vector<double> quality;  // [0, 1]
};

// Follows `from` (in the first pyramid) into the second, starting at `guess` (same length). Without
// `check` only forward: for points whose outliers a robust fit removes anyway.
Flow follow_points(const std::vector<cv::Mat>& first,
                   const std::vector<cv::Mat>& second,
                   const std::vector<Point2>& from,
                   const std::vector<Point2>& guess,
                   bool check = true);

}  // namespace zygoma
