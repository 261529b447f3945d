#include "tracker/landmarks.h"

#include <string_view>

#include "tracker/feature_schema.h"
#include "tracker/snake.h"

namespace zygoma {
namespace {

struct Line {
  std::string_view contour;
  std::vector<size_t> landmarks;  // in the order of the contour's nodes
};

const std::vector<Line>& lines() {
  static const std::vector<Line> all{
      {"brow_left", {22, 23, 24, 25, 26}},
      {"brow_right", {21, 20, 19, 18, 17}},
      {"nose_tip", {31, 32, 33, 34, 35}},
      {"upper_lip", {48, 49, 50, 51, 52, 53, 54}},
      {"lower_lip", {48, 59, 58, 57, 56, 55, 54}},
      {"chin_boss", {7, 8, 9}},
      {"eyelid_left", {42, 43, 44, 45}},
      {"eyelid_right", {39, 38, 37, 36}},
  };
  return all;
}

Point2 middle_of(const Landmarks& landmarks, size_t first, size_t last) {
  Point2 sum = Point2::Zero();
  for (size_t i = first; i <= last; ++i) sum += landmarks[i];
  return sum / static_cast<double>(last - first + 1);
}

// The landmarks are far apart on arcs that are round: a curve through them (Catmull and Rom's), of
// which the chords would cut the tops off. Ends continue straight.
std::vector<Point2> rounded(const std::vector<Point2>& points) {
  constexpr int kSteps = 6;
  const int n = static_cast<int>(points.size());
  const auto at = [&](int i) -> Point2 {
    if (i < 0) return 2.0 * points[0] - points[1];
    if (i >= n) return 2.0 * points[n - 1] - points[n - 2];
    return points[i];
  };
  std::vector<Point2> curve;
  for (int i = 0; i + 1 < n; ++i) {
    const Point2 p0 = at(i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
    for (int k = 0; k < kSteps; ++k) {
      const double t = static_cast<double>(k) / kSteps;
      curve.push_back(p1 + 0.5 * t *
                               ((p2 - p0) + t * ((2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) +
                                                 t * (3.0 * (p1 - p2) + p3 - p0))));
    }
  }
  curve.push_back(points.back());
  return curve;
}

}  // namespace

Point2 right_eye_of(const Landmarks& landmarks) { return middle_of(landmarks, 36, 41); }
Point2 left_eye_of(const Landmarks& landmarks) { return middle_of(landmarks, 42, 47); }

ContourSet contours_from_landmarks(const Landmarks& landmarks) {
  const Point2 lip_to_tip = landmarks[8] - landmarks[57];
  ContourSet set;
  for (const Feature& feature : kFeatureSchema) {
    Contour contour{std::string(feature.name), {}, 0.0, false};
    for (const Line& line : lines()) {
      if (line.contour != feature.name) continue;
      std::vector<Point2> points;
      for (const size_t i : line.landmarks) points.push_back(landmarks[i]);
      if (feature.name == "chin_boss") {
        for (Point2& p : points) p -= (1.0 - kChinBossShare) * lip_to_tip;
      }
      contour.points_px = resample(rounded(points), feature.num_nodes);
      contour.confidence = 1.0;
    }
    set.contours.push_back(std::move(contour));
  }
  return set;
}

}  // namespace zygoma
