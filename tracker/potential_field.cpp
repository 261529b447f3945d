#include "tracker/potential_field.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

double bilinear(const cv::Mat& field, double x, double y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double u = x - column;
  const double v = y - row;
  const float* top = field.ptr<float>(row) + column;
  const float* bottom = field.ptr<float>(row + 1) + column;
  return (1.0 - v) * ((1.0 - u) * static_cast<double>(top[0]) + u * static_cast<double>(top[1])) +
         v * ((1.0 - u) * static_cast<double>(bottom[0]) + u * static_cast<double>(bottom[1]));
}

// Central differences at the pixels, bilinear between them.
Point2 bilinear_slope(const cv::Mat& field, double x, double y) {
  return {0.5 * (bilinear(field, x + 1.0, y) - bilinear(field, x - 1.0, y)),
          0.5 * (bilinear(field, x, y + 1.0) - bilinear(field, x, y - 1.0))};
}

double percentile_of(const cv::Mat& values, double share) {
  // Every other pixel of every other row says as much.
  std::vector<float> sorted;
  sorted.reserve(values.total() / 4 + static_cast<size_t>(values.cols));
  for (int row = 0; row < values.rows; row += 2) {
    const float* line = values.ptr<float>(row);
    for (int column = 0; column < values.cols; column += 2) sorted.push_back(line[column]);
  }
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
  return static_cast<double>(sorted[static_cast<size_t>(at)]);
}

}  // namespace

PotentialField::PotentialField(const cv::Mat& image,
                               const cv::Rect& region,
                               const PotentialOptions& options) {
  region_ = region & cv::Rect(0, 0, image.cols, image.rows);
  if (region_.width < 4 || region_.height < 4) {
    region_ = cv::Rect();
    return;
  }
  cv::Mat source;
  // The smoothing may look beyond the region (not isolated), so a cut-out equals the whole picture.
  image(region_).convertTo(source, CV_32F);
  cv::Mat smooth;
  cv::GaussianBlur(
      source, smooth, cv::Size(), options.sigma_px, options.sigma_px, cv::BORDER_REPLICATE);
  const cv::Matx<float, 1, 3> difference(-0.5F, 0.0F, 0.5F);
  const cv::Matx<float, 1, 1> one(1.0F);
  cv::sepFilter2D(smooth, gradient_x_, CV_32F, difference, one, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sepFilter2D(smooth, gradient_y_, CV_32F, one, difference, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::magnitude(gradient_x_, gradient_y_, magnitude_);
  const double norm = std::max(options.floor, percentile_of(magnitude_, options.percentile));
  gradient_x_ /= norm;
  gradient_y_ /= norm;
  magnitude_ /= norm;
}

bool PotentialField::contains(const Point2& x) const {
  // Comparisons written so that a NaN is outside.
  return x.x() - region_.x >= 1.0 && x.y() - region_.y >= 1.0 &&
         x.x() - region_.x < region_.width - 2.5 && x.y() - region_.y < region_.height - 2.5;
}

Point2 PotentialField::image_gradient(const Point2& x) const {
  if (!contains(x)) return Point2::Zero();
  return {bilinear(gradient_x_, x.x() - region_.x, x.y() - region_.y),
          bilinear(gradient_y_, x.x() - region_.x, x.y() - region_.y)};
}

double PotentialField::potential(const Point2& x) const {
  return contains(x) ? -bilinear(magnitude_, x.x() - region_.x, x.y() - region_.y) : 0.0;
}

Point2 PotentialField::gradient(const Point2& x) const {
  if (!contains(x)) return Point2::Zero();
  return -bilinear_slope(magnitude_, x.x() - region_.x, x.y() - region_.y);
}

double PotentialField::potential(const Point2& x, const Point2& normal) const {
  return -std::max(0.0, normal.dot(image_gradient(x)));
}

Point2 PotentialField::gradient(const Point2& x, const Point2& normal) const {
  if (!contains(x) || normal.dot(image_gradient(x)) <= 0.0) return Point2::Zero();
  const double column = x.x() - region_.x;
  const double row = x.y() - region_.y;
  return -(normal.x() * bilinear_slope(gradient_x_, column, row) +
           normal.y() * bilinear_slope(gradient_y_, column, row));
}

}  // namespace zygoma
