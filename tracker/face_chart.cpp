#include "tracker/face_chart.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tracker/predictor.h"

namespace zygoma {
namespace {

enum class Channels { kColour, kGrey };

// The part of the picture under a box of the chart, shrunk by whole factors until one chart pixel
// covers at most 1.5 of its pixels (plain linear sampling would alias). `image_from_chart` becomes
// that of the part.
cv::Mat part_under(const Picture& picture,
                   Channels channels,
                   const cv::Rect& box,
                   Similarity& image_from_chart) {
  const int factor = std::max(1, static_cast<int>(std::floor(image_from_chart.scale() / 1.5)));
  double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;
  for (const cv::Point& corner : {box.tl(), {box.br().x, box.y}, {box.x, box.br().y}, box.br()}) {
    const Point2 p = image_from_chart.apply(Point2(corner.x, corner.y));
    left = std::min(left, p.x());
    right = std::max(right, p.x());
    top = std::min(top, p.y());
    bottom = std::max(bottom, p.y());
  }
  // Whole multiples of the factor, so that the shrunk grid does not shift as the face moves.
  const cv::Size size = picture.size();
  const int x0 = std::max(0, static_cast<int>(left) / factor - 1) * factor;
  const int y0 = std::max(0, static_cast<int>(top) / factor - 1) * factor;
  const int columns = (std::min(size.width, static_cast<int>(right) + 2 * factor) - x0) / factor;
  const int rows = (std::min(size.height, static_cast<int>(bottom) + 2 * factor) - y0) / factor;
  const auto taken = [&](const cv::Rect& part) {
    return channels == Channels::kGrey ? picture.grey(part) : picture.bgr(part);
  };
  if (columns < 2 || rows < 2) return taken({{}, size});
  const double f = factor;
  const Similarity part_from_image{
      1.0 / f, 0.0, Point2{(0.5 - x0) / f - 0.5, (0.5 - y0) / f - 0.5}};
  image_from_chart = part_from_image.after(image_from_chart);
  const cv::Mat part = taken(cv::Rect(x0, y0, columns * factor, rows * factor));
  if (factor == 1) return part;
  cv::Mat small;
  cv::resize(part, small, cv::Size(columns, rows), 0, 0, cv::INTER_AREA);
  return small;
}

// A box of the chart.
cv::Mat resampled(const Picture& picture,
                  Channels channels,
                  const cv::Rect& box,
                  Similarity image_from_chart) {
  const cv::Mat source = part_under(picture, channels, box, image_from_chart);
  const Similarity& s = image_from_chart;
  const Point2 corner = s.apply(Point2(box.x, box.y));
  const cv::Matx23d matrix(s.a, -s.b, corner.x(), s.b, s.a, corner.y());
  cv::Mat out;
  cv::warpAffine(source,
                 out,
                 matrix,
                 box.size(),
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return out;
}

const cv::Rect kLevelBox(60, 116, 73, 36);  // below the eyes, which close, to the base of the nose
constexpr double kExposureSlack = 0.03;
constexpr double kMostGain = 4.0;

// Dead flat pictures and those far too dark or bright are left as they are.
void meter(double level, Exposure& exposure) {
  if (exposure.level <= 0.0 || level < 1.0) return;
  const double right = exposure.level / level;
  if (std::abs(exposure.gain / right - 1.0) < kExposureSlack) return;
  exposure.gain = std::clamp(right, 1.0 / kMostGain, kMostGain);
}

void expose(cv::Mat& picture, double gain) {
  if (gain != 1.0) picture.convertTo(picture, -1, gain);
}

}  // namespace

Similarity image_from_chart(const Point2& right_eye_px, const Point2& left_eye_px) {
  return similarity_from_pair(
      chart_point(-0.5, 0.0), chart_point(0.5, 0.0), right_eye_px, left_eye_px);
}

double level_of(const FaceChart& chart) { return cv::mean(chart.grey(kLevelBox))[0]; }

FaceChart make_face_chart(const Picture& picture, const Similarity& image_from_chart, double gain) {
  FaceChart chart;
  chart.image_from_chart = image_from_chart;
  const cv::Rect all(0, 0, kChartWidth, kChartHeight);
  chart.colour = resampled(picture, Channels::kColour, all, image_from_chart);
  expose(chart.colour, gain);
  cv::cvtColor(chart.colour, chart.grey, cv::COLOR_BGR2GRAY);
  cv::buildOpticalFlowPyramid(chart.grey, chart.pyramid, kFlowWindow, kFlowLevels);
  return chart;
}

std::vector<cv::Mat> core_of(const FaceChart& chart) {
  std::vector<cv::Mat> core;
  // Cut out of the chart for good: a view would look beyond the box where a draft cannot.
  cv::buildOpticalFlowPyramid(chart.grey(kCoreBox).clone(), core, kFlowWindow, kFlowLevels);
  return core;
}

std::vector<cv::Mat> draft_of_core(const Picture& picture,
                                   const Similarity& image_from_chart,
                                   Exposure& exposure) {
  cv::Mat grey = resampled(picture, Channels::kGrey, kCoreBox, image_from_chart);
  meter(cv::mean(grey(kLevelBox - kCoreBox.tl()))[0], exposure);
  expose(grey, exposure.gain);
  std::vector<cv::Mat> core;
  cv::buildOpticalFlowPyramid(grey, core, kFlowWindow, kFlowLevels, false);
  return core;
}

}  // namespace zygoma
