#include "tracker/mouth_seam.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tracker/robust.h"

namespace zygoma {
namespace {

constexpr int kReach = 53;            // chart px from within the mouth outwards
constexpr int kInside = 23;           // chart px within the corner where the walk begins
constexpr int kBefore = 2;            // chart px before its end the seam's height is read
constexpr int kBeforeStep = 16;       // chart px of the seam that are held against
constexpr int kAfterStep = 12;        // as many of what comes after it
constexpr int kAcross = 4;            // chart px of the second difference
constexpr int kHeight = 24;           // chart px of the picture above and below the corners
constexpr int kSeamSearch = 6;        // chart px above and below, where the walk begins
constexpr double kStay = 0.02;        // of the seam's strength, per chart px away from the corner
constexpr double kOutlier = 5.0;      // chart px of disagreement beyond which the seam is doubted
constexpr double kShareAlong = 0.6;   // of the seam's word on how far out the corner is
constexpr double kShareAcross = 0.8;  // and on its height, which no crease prolongs
constexpr int kFirst = 10;            // frames that the first counts for
constexpr int kMemory = 300;          // frames

// How much a pixel lies on a dark line that runs across the picture.
cv::Mat darkness_of_lines(const cv::Mat& grey) {
  cv::Mat smooth, wide;
  grey.convertTo(wide, CV_32F);
  cv::GaussianBlur(wide, smooth, cv::Size(), 2.5, 2.2, cv::BORDER_REPLICATE);
  cv::Mat line(2 * kAcross + 1, 1, CV_32F, cv::Scalar(0.0));
  line.at<float>(0) = line.at<float>(2 * kAcross) = 0.25F;
  line.at<float>(kAcross) = -0.5F;
  const cv::Mat one = cv::Mat::ones(1, 1, CV_32F);
  cv::Mat out;
  cv::sepFilter2D(smooth, out, CV_32F, one, line, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return out;
}

// Row of the largest value of a column within [first, last].
int strongest(const cv::Mat& map, int column, int first, int last) {
  int best = std::clamp(first, 0, map.rows - 1);
  for (int row = best; row <= std::min(last, map.rows - 1); ++row) {
    if (map.at<float>(row, column) > map.at<float>(best, column)) best = row;
  }
  return best;
}

// Row of a line's middle between pixels.
double between_rows(const cv::Mat& map, int column, int row) {
  if (row < 1 || row + 1 >= map.rows) return row;
  const auto at = [&](int r) { return static_cast<double>(map.at<float>(r, column)); };
  return row + parabola_summit(at(row - 1), at(row), at(row + 1));
}

// The step down in strength along the seam that starts at (x0, row) and goes `outwards`.
Point2 seam_end(const cv::Mat& map, int x0, int row, int outwards, const Point2& corner) {
  std::array<double, kReach> strength{};
  std::array<double, kReach> height{};
  for (int k = 0; k < kReach; ++k) {
    const int x = x0 + outwards * k;
    if (x < 0 || x >= map.cols) break;
    row = strongest(map, x, row - 1, row + 1);
    strength[static_cast<size_t>(k)] = std::max(0.0F, map.at<float>(row, x));
    height[static_cast<size_t>(k)] = between_rows(map, x, row);
  }
  std::array<double, kReach + 1> sum{};
  for (size_t k = 0; k < kReach; ++k) sum[k + 1] = sum[k] + strength[k];
  std::array<double, kReach> sorted = strength;
  std::nth_element(sorted.begin(), sorted.begin() + kReach / 2, sorted.end());
  const double stay = kStay * sorted[kReach / 2];
  const auto gain = [&](int t) {
    const auto at = [&](int k) { return sum[static_cast<size_t>(k)]; };
    return (at(t) - at(t - kBeforeStep)) / kBeforeStep - (at(t + kAfterStep) - at(t)) / kAfterStep -
           stay * std::abs(x0 + outwards * t - corner.x());
  };
  int best = kBeforeStep;
  for (int t = kBeforeStep; t < kReach - kAfterStep; ++t) {
    if (gain(t) > gain(best)) best = t;
  }
  if (!(gain(best) > 0.0)) return corner;
  double end = best;
  if (best > kBeforeStep && best + 1 < kReach - kAfterStep) {
    end += parabola_summit(gain(best - 1), gain(best), gain(best + 1));
  }
  return {x0 + outwards * (end - 0.5), height[static_cast<size_t>(best - kBefore)]};
}

}  // namespace

MouthCorners find_seam_ends(const cv::Mat& grey, const MouthCorners& corners) {
  const double middle = 0.5 * (corners[kRightCorner].x() + corners[kLeftCorner].x());
  const double half = 0.5 * (corners[kLeftCorner].x() - corners[kRightCorner].x());
  const double highest = std::min(corners[kRightCorner].y(), corners[kLeftCorner].y());
  const double lowest = std::max(corners[kRightCorner].y(), corners[kLeftCorner].y());
  const int first = std::max(0, static_cast<int>(highest) - kHeight);
  const int last = std::min(grey.rows, static_cast<int>(lowest) + kHeight);
  MouthCorners ends = corners;
  if (last - first < 2 * kSeamSearch || !(half > 0.0)) return ends;
  const cv::Mat map = darkness_of_lines(grey.rowRange(first, last));
  for (size_t side = 0; side < kNumCorners; ++side) {
    const int outwards = side == kLeftCorner ? 1 : -1;
    const double start = middle + outwards * std::max(0.35 * half, half - kInside);
    const int x0 = std::clamp(static_cast<int>(std::lround(start)), 0, grey.cols - 1);
    const int row = static_cast<int>(std::lround(corners[side].y())) - first;
    const int on_seam = strongest(map, x0, row - kSeamSearch, row + kSeamSearch);
    const Point2 above(0.0, first);
    ends[side] = above + seam_end(map, x0, on_seam, outwards, corners[side] - above);
  }
  return ends;
}

MouthCorners SeamCorners::refine(const cv::Mat& grey, const MouthCorners& corners) {
  const MouthCorners ends = find_seam_ends(grey, corners);
  const bool first = frames_ == 0;
  frames_ = first ? kFirst : std::min(frames_ + 1, kMemory);
  MouthCorners refined = corners;
  for (size_t side = 0; side < kNumCorners; ++side) {
    const Point2 found = ends[side] - corners[side];
    usual_px_[side] = first ? found : usual_px_[side] + (found - usual_px_[side]) / frames_;
    const Point2 news = found - usual_px_[side];
    const double trust = 1.0 / (1.0 + news.squaredNorm() / (kOutlier * kOutlier));
    refined[side] += trust * Point2(kShareAlong * news.x(), kShareAcross * news.y());
  }
  return refined;
}

}  // namespace zygoma
