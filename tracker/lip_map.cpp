#include "tracker/lip_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

constexpr size_t kFewest = 60;          // pixels of either class
constexpr double kSoftness_px = 1.2;    // the grain of a dark picture is no lip
constexpr float kLipLevel = 0.85F;      // of the map at the typical lip
constexpr float kLeastDistance = 1.2F;  // of the typical lip from skin, in spreads

// 255 (1 - exp(-t)) for t = i / kTableScale; steps of half a level at most.
constexpr float kTableEnd = 7.99F;
constexpr float kTableScale = 512.0F;
const std::vector<float>& saturation() {
  static const std::vector<float> table = [] {
    std::vector<float> values(8 * static_cast<size_t>(kTableScale));
    for (size_t i = 0; i < values.size(); ++i) {
      values[i] = 255.0F * (1.0F - std::exp(-static_cast<float>(i) / kTableScale));
    }
    return values;
  }();
  return table;
}

}  // namespace

std::vector<Point2> mouth_outline(const std::vector<Point2>& upper_lip,
                                  const std::vector<Point2>& lower_lip) {
  std::vector<Point2> outline = upper_lip;
  outline.insert(outline.end(), lower_lip.rbegin(), lower_lip.rend());
  return outline;
}

cv::Mat outline_mask(const cv::Size& size,
                     const std::vector<Point2>& outline,
                     double factor,
                     double more_px) {
  Point2 middle = Point2::Zero();
  for (const Point2& p : outline) middle += p / static_cast<double>(outline.size());
  std::vector<cv::Point> polygon;
  for (const Point2& p : outline) {
    const Point2 out = p - middle;
    const Point2 q = middle + factor * out + more_px * out.normalized();
    polygon.emplace_back(static_cast<int>(std::lround(q.x())),
                         static_cast<int>(std::lround(q.y())));
  }
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{polygon}, cv::Scalar(255));
  return mask;
}

Eigen::Vector3f colour_features(const cv::Vec3b& bgr) {
  const float blue = bgr[0];
  const float green = bgr[1];
  const float red = bgr[2];
  return {(red + 8.0F) / (red + green + 16.0F),
          (blue + 6.0F) / (red + green + blue + 18.0F),
          (0.3F * red + 0.6F * green + 0.1F * blue) / 255.0F};
}

bool LipMap::learn(const cv::Mat& bgr,
                   const std::vector<Point2>& upper_lip,
                   const std::vector<Point2>& lower_lip) {
  const std::vector<Point2> outline = mouth_outline(upper_lip, lower_lip);
  cv::Mat soft;
  cv::GaussianBlur(bgr, soft, cv::Size(), kSoftness_px);
  const cv::Mat near = outline_mask(bgr.size(), outline, 1.05, 4.0);
  const cv::Mat far = outline_mask(bgr.size(), outline, 1.1, 14.0);
  const cv::Mat inside = outline_mask(bgr.size(), outline, 0.9, -1.0);
  std::vector<Eigen::Vector3f> skin, lips;
  for (int row = 0; row < bgr.rows; ++row) {
    for (int column = 0; column < bgr.cols; ++column) {
      if (inside.at<uchar>(row, column)) {
        lips.push_back(colour_features(soft.at<cv::Vec3b>(row, column)));
      } else if (far.at<uchar>(row, column) && !near.at<uchar>(row, column)) {
        skin.push_back(colour_features(soft.at<cv::Vec3b>(row, column)));
      }
    }
  }
  if (skin.size() < kFewest || lips.size() < kFewest) return false;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const auto& f : skin) mean += f / static_cast<float>(skin.size());
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  for (const auto& f : skin) {
    covariance += (f - mean) * (f - mean).transpose() / static_cast<float>(skin.size());
  }
  // Floors: half a grey level of hue, and the shading a moving head brings.
  covariance.diagonal() += Eigen::Vector3f(2e-5F, 2e-5F, 2e-3F);
  const Eigen::LLT<Eigen::Matrix3f> factor(covariance);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::Matrix3f whiten =
      factor.matrixL().solve(Eigen::Matrix3f(Eigen::Matrix3f::Identity()));
  std::vector<float> distance;
  for (const auto& f : lips) distance.push_back((whiten * (f - mean)).norm());
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  if (!std::isfinite(*middle) || *middle < kLeastDistance) return false;
  mean_ = mean;
  whiten_ = whiten;
  scale_ = *middle / std::sqrt(-2.0F * std::log(1.0F - kLipLevel));
  learned_ = true;
  return true;
}

cv::Mat LipMap::apply(const cv::Mat& bgr) const {
  cv::Mat soft;
  cv::GaussianBlur(bgr, soft, cv::Size(), kSoftness_px);
  cv::Mat map(bgr.size(), CV_32F);
  const Eigen::Matrix3f scaled = whiten_ / scale_;
  const Eigen::Vector3f shift = scaled * mean_;
  const std::vector<float>& table = saturation();
  for (int row = 0; row < bgr.rows; ++row) {
    const cv::Vec3b* in = soft.ptr<cv::Vec3b>(row);
    float* out = map.ptr<float>(row);
    for (int column = 0; column < bgr.cols; ++column) {
      const Eigen::Vector3f f = colour_features(in[column]);
      if (!learned_) {
        out[column] = 255.0F * f[0];
        continue;
      }
      // whiten_ is a lower triangle.
      const float a = scaled(0, 0) * f[0] - shift[0];
      const float b = scaled(1, 0) * f[0] + scaled(1, 1) * f[1] - shift[1];
      const float c = scaled(2, 0) * f[0] + scaled(2, 1) * f[1] + scaled(2, 2) * f[2] - shift[2];
      const float half_square = 0.5F * (a * a + b * b + c * c);
      out[column] = table[static_cast<size_t>(std::min(kTableEnd, half_square) * kTableScale)];
    }
  }
  return map;
}

}  // namespace zygoma
