#include "tracker/mirror.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

#include "tracker/face_chart.h"

namespace zygoma {
namespace {

constexpr std::string_view kLeft = "_left";
constexpr std::string_view kRight = "_right";

// The contour that this one is in the mirror.
std::string twin_of(std::string_view name) {
  const auto with = [&](std::string_view end, std::string_view other) {
    return std::string(name.substr(0, name.size() - end.size())) + std::string(other);
  };
  if (name.ends_with(kLeft)) return with(kLeft, kRight);
  if (name.ends_with(kRight)) return with(kRight, kLeft);
  return std::string(name);
}

// One that crosses the middle runs from the subject's right to left: in the mirror it would run
// back.
bool crosses_middle(std::string_view name) { return twin_of(name) == name; }

constexpr double kStepsOfPixel = 0x1p20;
constexpr double kStepsOfHead = 0x1p32;  // a and b multiply chart pixels

// The landmark that this one is in the mirror.
size_t twin_of(size_t landmark) {
  // Runs of landmarks that change places back to front.
  struct Run {
    size_t first, last;
    size_t sum;  // of a landmark's number and its twin's
  };
  constexpr std::array<Run, 10> kRuns{{{0, 16, 16},
                                       {17, 26, 43},
                                       {31, 35, 66},
                                       {36, 39, 81},
                                       {40, 41, 87},
                                       {42, 45, 81},
                                       {46, 47, 87},
                                       {48, 54, 102},
                                       {55, 59, 114},
                                       {60, 64, 124}}};
  for (const Run& run : kRuns) {
    if (landmark >= run.first && landmark <= run.last) return run.sum - landmark;
  }
  return landmark >= 65 ? 132 - landmark : landmark;  // inner lower lip; bridge of the nose
}

double on_grid(double x, double steps = kStepsOfPixel) {
  constexpr double kMostSteps = 0x1p51;
  const double n = x * steps;
  return std::abs(n) < kMostSteps ? std::nearbyint(n) / steps : x;
}

Point2 on_grid(const Point2& p, double steps = kStepsOfPixel) {
  return {on_grid(p.x(), steps), on_grid(p.y(), steps)};
}

// M, all channels together.
std::int64_t lopsidedness(const cv::Mat& picture) {
  cv::Mat sums;
  cv::reduce(picture, sums, 0, cv::REDUCE_SUM, CV_32S);
  const int channels = sums.channels();
  const std::int32_t* sum = sums.ptr<std::int32_t>(0);
  std::int64_t moment = 0;
  for (int x = 0; x < sums.cols; ++x) {
    for (int c = 0; c < channels; ++c) {
      moment += std::int64_t{2 * x - (sums.cols - 1)} * sum[x * channels + c];
    }
  }
  return moment;
}

// Below zero: the first pixel that differs from its twin is the darker of the two.
int first_difference(const cv::Mat& picture) {
  const size_t pixel = picture.elemSize();
  for (int row = 0; row < picture.rows; ++row) {
    const std::uint8_t* line = picture.ptr(row);
    for (int x = 0; x < picture.cols / 2; ++x) {
      const int sign = std::memcmp(line + static_cast<size_t>(x) * pixel,
                                   line + static_cast<size_t>(picture.cols - 1 - x) * pixel,
                                   pixel);
      if (sign != 0) return sign;
    }
  }
  return 0;
}

}  // namespace

void Mirror::decide(const Frame& frame) {
  if (turns_ || Picture(frame).empty()) return;
  std::int64_t moment = 0;
  int first = 0;
  for (const cv::Mat* layer : {&frame.image, &frame.planes.y, &frame.planes.cb, &frame.planes.cr}) {
    if (layer->empty()) continue;
    moment += lopsidedness(*layer);
    if (first == 0) first = first_difference(*layer);
  }
  if (moment != 0 || first != 0) turns_ = moment != 0 ? moment < 0 : first < 0;
}

void Mirror::decide(const ContourSet& given, int width) {
  double moment = 0.0;  // exact: few numbers on a grid
  for (const Contour& contour : given.contours) {
    for (const Point2& p : contour.points_px) moment += 2.0 * on_grid(p.x()) - (width - 1.0);
  }
  if (!turns_ && moment != 0.0) turns_ = moment < 0.0;
}

ContourSet Mirror::of(ContourSet set, int width) const {
  for (Contour& contour : set.contours) {
    for (Point2& p : contour.points_px) {
      p = on_grid(p);
      if (turns()) p.x() = width - 1.0 - p.x();
    }
  }
  if (!turns()) return set;
  for (Contour& contour : set.contours) {
    if (crosses_middle(contour.name)) {
      std::reverse(contour.points_px.begin(), contour.points_px.end());
    }
    contour.name = twin_of(contour.name);
  }
  // Left stays in the place of left.
  for (auto a = set.contours.begin(); a != set.contours.end(); ++a) {
    for (auto b = a + 1; b != set.contours.end(); ++b) {
      if (!crosses_middle(a->name) && a->name == twin_of(b->name)) std::swap(*a, *b);
    }
  }
  return set;
}

Landmarks Mirror::of(const Landmarks& landmarks, int width) const {
  Landmarks out;
  for (size_t i = 0; i < kNumLandmarks; ++i) {
    const Point2 p = on_grid(landmarks[i]);
    out[turns() ? twin_of(i) : i] = turns() ? Point2(width - 1.0 - p.x(), p.y()) : p;
  }
  return out;
}

// The chart's own picture turns about its middle as well.
Similarity Mirror::of(Similarity s, int width) const {
  s = {on_grid(s.a, kStepsOfHead), on_grid(s.b, kStepsOfHead), on_grid(s.shift, kStepsOfHead)};
  if (!turns()) return s;
  const double last = kChartWidth - 1.0;
  return {s.a, -s.b, Point2(width - 1.0 - last * s.a - s.shift.x(), last * s.b + s.shift.y())};
}

Correction Mirror::of(Correction correction, int width) const {
  correction.at_px = on_grid(correction.at_px);
  correction.along = on_grid(correction.along);
  if (!turns()) return correction;
  correction.at_px.x() = width - 1.0 - correction.at_px.x();
  if (crosses_middle(correction.contour)) correction.along = 1.0 - correction.along;
  correction.contour = twin_of(correction.contour);
  return correction;
}

Mirror::Terms Mirror::of(Terms terms) const {
  if (!turns()) return terms;
  for (size_t a = 0; a < kFeatureSchema.size(); ++a) {
    for (size_t b = a + 1; b < kFeatureSchema.size(); ++b) {
      if (twin_of(kFeatureSchema[a].name) == kFeatureSchema[b].name) std::swap(terms[a], terms[b]);
    }
  }
  return terms;
}

}  // namespace zygoma
