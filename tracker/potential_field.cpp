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

// The magnitude that a share of the region stays below.
double percentile_of(const cv::Mat& values, double share) {
  // One pixel of nine says as much, unless it is the very largest that is wanted.
  const int stride = share < 1.0 ? 3 : 1;
  std::vector<float> sorted;
  sorted.reserve(values.total());
  for (int row = 0; row < values.rows; row += stride) {
    const float* line = values.ptr<float>(row);
    for (int column = 0; column < values.cols; column += stride) sorted.push_back(line[column]);
  }
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
  return static_cast<double>(sorted[static_cast<size_t>(at)]);
}

// Central differences of the whole picture at once; the border repeats.
void differentiate(const cv::Mat& smooth, cv::Mat& dx, cv::Mat& dy, cv::Mat& magnitude) {
  const int rows = smooth.rows;
  const int columns = smooth.cols;
  dx.create(smooth.size(), CV_32F);
  dy.create(smooth.size(), CV_32F);
  magnitude.create(smooth.size(), CV_32F);
  for (int row = 0; row < rows; ++row) {
    const float* above = smooth.ptr<float>(std::max(0, row - 1));
    const float* here = smooth.ptr<float>(row);
    const float* below = smooth.ptr<float>(std::min(rows - 1, row + 1));
    float* out_x = dx.ptr<float>(row);
    float* out_y = dy.ptr<float>(row);
    float* out = magnitude.ptr<float>(row);
    out_x[0] = 0.5F * (here[1] - here[0]);
    for (int i = 1; i + 1 < columns; ++i) out_x[i] = 0.5F * (here[i + 1] - here[i - 1]);
    out_x[columns - 1] = 0.5F * (here[columns - 1] - here[columns - 2]);
    for (int i = 0; i < columns; ++i) {
      out_y[i] = 0.5F * (below[i] - above[i]);
      out[i] = std::sqrt(out_x[i] * out_x[i] + out_y[i] * out_y[i]);
    }
  }
}

}  // namespace

PotentialField::PotentialField(const cv::Mat& image,
                               const cv::Rect& region,
                               const PotentialOptions& options) {
  const cv::Rect wanted = region & cv::Rect(0, 0, image.cols, image.rows);
  const cv::Size size = wanted.size() / options.shrink;
  if (size.width < 4 || size.height < 4) return;
  const cv::Rect whole(wanted.tl(), size * options.shrink);
  scale_ = 1.0 / options.shrink;
  offset_ = scale_ * Point2(0.5 - whole.x, 0.5 - whole.y) - Point2(0.5, 0.5);
  end_ = Point2(size.width - 2.5, size.height - 2.5);
  cv::Mat part = image(whole), source, smooth;
  if (options.shrink > 1) cv::resize(image(whole), part, size, 0, 0, cv::INTER_AREA);
  part.convertTo(source, CV_32F);
  const double sigma_px = scale_ * options.sigma_px;
  const int kernel = 2 * static_cast<int>(std::ceil(3.0 * sigma_px)) + 1;
  cv::GaussianBlur(
      source, smooth, cv::Size(kernel, kernel), sigma_px, sigma_px, cv::BORDER_REPLICATE);
  differentiate(smooth, gradient_x_, gradient_y_, magnitude_);
  // Applied where a value is read: far fewer places than pixels.
  unit_ =
      1.0 / std::max(options.shrink * options.floor, percentile_of(magnitude_, options.percentile));
}

Point2 PotentialField::place_of(const Point2& x) const { return scale_ * x + offset_; }

bool PotentialField::holds(const Point2& place) const {
  // Comparisons written so that a NaN is outside.
  return place.x() >= 1.0 && place.y() >= 1.0 && place.x() < end_.x() && place.y() < end_.y();
}

bool PotentialField::contains(const Point2& x) const { return holds(place_of(x)); }

Point2 PotentialField::gradient_at(const Point2& place) const {
  const int i = static_cast<int>(place.x());
  const int j = static_cast<int>(place.y());
  const auto u = static_cast<float>(place.x() - i);
  const auto v = static_cast<float>(place.y() - j);
  const float w00 = (1.0F - u) * (1.0F - v), w01 = u * (1.0F - v);
  const float w10 = (1.0F - u) * v, w11 = u * v;
  const auto blend = [&](const cv::Mat& field) {
    const float* top = field.ptr<float>(j) + i;
    const float* bottom = field.ptr<float>(j + 1) + i;
    return unit_ *
           static_cast<double>(w00 * top[0] + w01 * top[1] + w10 * bottom[0] + w11 * bottom[1]);
  };
  return {blend(gradient_x_), blend(gradient_y_)};
}

Point2 PotentialField::image_gradient(const Point2& x) const {
  const Point2 place = place_of(x);
  return holds(place) ? gradient_at(place) : Point2(0.0, 0.0);
}

double PotentialField::potential(const Point2& x) const {
  const Point2 place = place_of(x);
  return holds(place) ? -unit_ * bilinear(magnitude_, place.x(), place.y()) : 0.0;
}

Point2 PotentialField::gradient(const Point2& x) const {
  const Point2 place = place_of(x);
  if (!holds(place)) return Point2::Zero();
  return -unit_ * scale_ * bilinear_slope(magnitude_, place.x(), place.y());
}

double PotentialField::potential(const Point2& x, const Point2& normal) const {
  return -std::max(0.0, normal.dot(image_gradient(x)));
}

Point2 PotentialField::gradient(const Point2& x, const Point2& normal) const {
  const Point2 place = place_of(x);
  if (!holds(place) || normal.dot(gradient_at(place)) <= 0.0) return Point2::Zero();
  return -unit_ * scale_ *
         (normal.x() * bilinear_slope(gradient_x_, place.x(), place.y()) +
          normal.y() * bilinear_slope(gradient_y_, place.x(), place.y()));
}

}  // namespace zygoma
