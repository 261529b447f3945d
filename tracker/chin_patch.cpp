#include "tracker/chin_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "tracker/robust.h"

namespace zygoma {
namespace {

// About the middle of the boss, chart px; even, for the coarse search.
constexpr int kLeft = 26, kRight = 26, kAbove = 26, kBelow = 14;
// How far a jaw goes; the coarse search is exhaustive.
constexpr int kAside = 8, kUp = 14, kDown = 32;
constexpr int kFineReach = 2;

// Both maps must have a spread, or the correlation is a division of nothing by nothing.
bool is_flat(const cv::Mat& picture) {
  cv::Scalar mean, spread;
  cv::meanStdDev(picture, mean, spread);
  return spread[0] < 0.5;
}

// Normalised correlation of the patch with every place of a picture, float, [-1, 1]. Directly: for
// so few places matchTemplate's Fourier transforms cost several times as much.
cv::Mat correlations(const cv::Mat& picture, const cv::Mat& patch) {
  cv::Mat_<double> sums, squares;
  cv::integral(picture, sums, squares, CV_64F, CV_64F);
  const auto over = [&](const cv::Mat_<double>& table, int x, int y) {
    return table(y, x) + table(y + patch.rows, x + patch.cols) - table(y, x + patch.cols) -
           table(y + patch.rows, x);
  };
  const double n = static_cast<double>(patch.total());
  const double mean = cv::mean(patch)[0];
  const double patch_spread = cv::norm(patch, cv::NORM_L2SQR) - n * mean * mean;
  cv::Mat out(picture.rows - patch.rows + 1, picture.cols - patch.cols + 1, CV_32F);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      int product = 0;
      for (int row = 0; row < patch.rows; ++row) {
        const std::uint8_t* p = patch.ptr(row);
        const std::uint8_t* q = picture.ptr(y + row) + x;
        for (int i = 0; i < patch.cols; ++i) product += p[i] * q[i];
      }
      const double sum = over(sums, x, y);
      const double spread = over(squares, x, y) - sum * sum / n;
      const double both = std::sqrt(std::max(1.0, spread) * patch_spread);
      out.at<float>(y, x) = static_cast<float>((product - mean * sum) / both);
    }
  }
  return out;
}

}  // namespace

void ChinPatch::learn(const cv::Mat& grey, const Point2& chin) {
  const cv::Rect all(0, 0, grey.cols, grey.rows);
  const cv::Rect wanted(static_cast<int>(std::lround(chin.x())) - kLeft,
                        static_cast<int>(std::lround(chin.y())) - kAbove,
                        kLeft + kRight,
                        kAbove + kBelow);
  place_ = wanted & all;
  patch_.release();
  if (place_.width < wanted.width / 2 || place_.height < wanted.height / 2) return;
  if (is_flat(grey(place_))) return;
  patch_ = grey(place_).clone();
  cv::resize(patch_, small_patch_, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
}

ChinPatch::Sight ChinPatch::find(const cv::Mat& grey) const {
  Sight sight;
  if (patch_.empty()) return sight;
  const cv::Rect all(0, 0, grey.cols, grey.rows);
  const cv::Rect range = cv::Rect(place_.x - kAside,
                                  place_.y - kUp,
                                  place_.width + 2 * kAside,
                                  place_.height + kUp + kDown) &
                         all;
  if (is_flat(grey(range))) return sight;
  cv::Mat small;
  cv::resize(grey(range), small, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
  cv::Mat match = correlations(small, small_patch_);
  cv::Point coarse;
  cv::minMaxLoc(match, nullptr, nullptr, nullptr, &coarse);

  const cv::Rect about = cv::Rect(range.x + 2 * coarse.x - kFineReach - 1,
                                  range.y + 2 * coarse.y - kFineReach - 1,
                                  place_.width + 2 * kFineReach + 2,
                                  place_.height + 2 * kFineReach + 2) &
                         all;
  if (about.width < place_.width + 2 || about.height < place_.height + 2) return sight;
  match = correlations(grey(about), patch_);
  cv::Point best;
  double likeness = 0.0;
  cv::minMaxLoc(match, nullptr, &likeness, nullptr, &best);
  const auto at = [&](int x, int y) { return static_cast<double>(match.at<float>(y, x)); };
  Point2 found(about.x + best.x, about.y + best.y);
  if (best.x > 0 && best.x + 1 < match.cols) {
    found.x() += parabola_summit(at(best.x - 1, best.y), likeness, at(best.x + 1, best.y));
  }
  if (best.y > 0 && best.y + 1 < match.rows) {
    found.y() += parabola_summit(at(best.x, best.y - 1), likeness, at(best.x, best.y + 1));
  }
  if (!std::isfinite(likeness)) return sight;
  return {found - Point2(place_.x, place_.y), likeness};
}

}  // namespace zygoma
