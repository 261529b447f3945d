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

// Chart px, a quarter of the eye distance by a sixth: rows of sixteen fill the registers of
// OpenCV's loops, and cost half as much as thirteen.
inline const cv::Size kFlowWindow{16, 11};
inline constexpr int kFlowLevels = 2;  // pyramid levels above the finest

struct Flow {
  std::vector<Point2> points_px;
  std::vector<double> quality;  // [0, 1]
};

// Follows `from` (in the first pyramid) into the second, starting at `guess` (same length). Without
// `check` only forward: for points whose outliers a robust fit removes anyway. Fewer `levels` do
// where the guess is already near.
Flow follow_points(const std::vector<cv::Mat>& first,
                   const std::vector<cv::Mat>& second,
                   const std::vector<Point2>& from,
                   const std::vector<Point2>& guess,
                   bool check = true,
                   int levels = kFlowLevels);

}  // namespace zygoma
