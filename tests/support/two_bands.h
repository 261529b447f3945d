// A track of the left brow over pictures that stand still and have two edges for it to rest on.
#pragma once

#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tracker/correction.h"
#include "tracker/evidence.h"
#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"

namespace zygoma {

inline constexpr double kBrowRow = 80.0;   // brightness falls downwards here ...
inline constexpr double kOtherRow = 92.0;  // ... and here
inline constexpr int kNumFrames = 40;
inline constexpr int kCorrected = 15;

// Two dark bands right across the chart: two edges that look like the upper edge of a brow.
inline FaceChart two_bands() {
  cv::Mat image(kChartHeight, kChartWidth, CV_8UC3, cv::Scalar::all(180));
  for (const double row : {kBrowRow, kOtherRow}) {
    cv::rectangle(image,
                  cv::Point(0, static_cast<int>(row) + 1),
                  cv::Point(kChartWidth, static_cast<int>(row) + 6),
                  cv::Scalar::all(60),
                  cv::FILLED);
  }
  cv::GaussianBlur(image, image, cv::Size(), 1.0);
  return make_face_chart(image, Similarity{});
}

inline std::vector<FaceChart> charts() { return std::vector<FaceChart>(kNumFrames, two_bands()); }

// The left brow on the first band, everything else lost.
inline std::vector<ContourSet> automatic_track() {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) nodes.emplace_back(110.0 + 5.0 * i, kBrowRow + 0.5);
  std::vector<ContourSet> track(kNumFrames);
  for (int k = 0; k < kNumFrames; ++k) {
    track[k].frame_index = k;
    for (const Feature& feature : kFeatureSchema) {
      track[k].contours.push_back({std::string(feature.name), {}, 0.0, false});
    }
    track[k].contours[kBrowLeft].points_px = nodes;
    track[k].contours[kBrowLeft].confidence = 0.5;
  }
  return track;
}

inline Correction pull(double to_row, MouseForce force = MouseForce::kSpring) {
  Correction correction;
  correction.id = 1;
  correction.frame = kCorrected;
  correction.contour = "brow_left";
  correction.force = force;
  correction.along = 0.5;
  correction.at_px = {130.0, to_row};
  correction.stiffness = 8.0;
  correction.radius = force == MouseForce::kVolcano ? 20.0 : 1.0;
  return correction;
}

inline std::vector<ContourSet> corrected(const std::vector<Correction>& corrections) {
  std::vector<ContourSet> track = automatic_track();
  for (const FrameRange& range : reach_of(corrections, kNumFrames)) {
    std::vector<FaceChart> all = charts();
    apply_corrections(corrections,
                      range,
                      {all.begin() + range.first, all.begin() + range.last + 1},
                      LipMap(),
                      track);
  }
  return track;
}

inline double middle_row(const ContourSet& set) { return set.contours[kBrowLeft].points_px[4].y(); }

}  // namespace zygoma
