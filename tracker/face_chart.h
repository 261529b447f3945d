// The face chart: the frame resampled so that the face is upright and its eyes are always the same
// distance apart.
//
// Every length of the tracker (smoothing, search range, snake constants) is then a fixed share of
// the eye distance, whether the face is 90 or 500 pixels wide; the work per frame does not grow
// with the picture; and a contour's motion in the chart is expression, because the head's motion
// has been taken off by the resampling itself.
//
// Chart pixels: eye middle at kChartEyeMiddle, eyes kChartEyeDistance apart on a horizontal line,
// the subject's right on the left, as in the picture.
//
// The charts of one track are exposed alike: flow takes brightness for constant, and what skin and
// lips look like was learned once. The gain that keeps the middle of the face at the level of the
// first chart is left alone until it is wrong by a few per cent, so that steady light stays steady.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tracker/head_frame.h"
#include "tracker/picture.h"

namespace zygoma {

inline constexpr double kChartEyeDistance = 64.0;
inline constexpr int kChartWidth = 193;
inline constexpr int kChartHeight = 272;
inline const Point2 kChartEyeMiddle{96.0, 104.0};

// The part that does not move with expression, eyes to base of the nose, with room for the head to
// have moved.
inline const cv::Rect kCoreBox{16, 68, 161, 112};

struct Exposure {
  double level = 0.0;  // grey wanted in the middle of the face; 0: as it comes
  double gain = 1.0;   // of the last chart
};

struct FaceChart {
  Similarity image_from_chart;
  cv::Mat colour;                // 8-bit BGR
  cv::Mat grey;                  // 8-bit
  std::vector<cv::Mat> pyramid;  // of grey, for optical flow
};

// The place of the face given its eye centres in the image.
Similarity image_from_chart(const Point2& right_eye_px, const Point2& left_eye_px);

// Chart pixels of a point in eye-distance units about the eye middle.
inline Point2 chart_point(double x_iod, double y_iod) {
  return kChartEyeMiddle + kChartEyeDistance * Point2{x_iod, y_iod};
}

// Resamples the picture. Outside it the border repeats.
FaceChart make_face_chart(const Picture& picture,
                          const Similarity& image_from_chart,
                          double gain = 1.0);
// The pyramid of a chart's core, and that of a chart that has nothing else: it can only be flowed
// *to*. The latter measures the exposure.
std::vector<cv::Mat> core_of(const FaceChart& chart);
std::vector<cv::Mat> draft_of_core(const Picture& picture,
                                   const Similarity& image_from_chart,
                                   Exposure& exposure);
// Mean grey of the middle of the face.
double level_of(const FaceChart& chart);

}  // namespace zygoma
