#include "tracker/mouth_start.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace zygoma {
namespace {

constexpr int kRounds = 3;        // of finding and learning
constexpr int kMargin = 10;       // chart px about all outlines found: the picture that is parted
constexpr double kShade = 0.11;   // nats per pixel
constexpr double kBlur_px = 1.2;  // the grain is not a region's colour
// Least variances of hue, share of blue and brightness: rounding, compression, shading.
const Eigen::Vector3d kFloor(2e-5, 2e-5, 2e-3);

// Where the search starts: closed, pursed, open, wide open, smiling with teeth.
struct UsualMouth {
  Mouth mouth;
  bool closed = true;
};
const std::array<UsualMouth, 5>& usual_mouths() {
  static const std::array<UsualMouth, 5> mouths{{
      {Mouth(), true},
      {{{1.15, 0.17, 0.15, 0.0, 0.28, 0.0, 0.0}}, true},
      {{{1.15, 0.34, 0.15, 0.0, 0.36, 0.0, 0.0}}, false},
      {{{1.15, 0.52, 0.20, 0.0, 0.33, 0.0, 0.0}}, false},
      {{{1.08, 0.30, 0.12, 0.0, 0.48, 0.0, 0.06}}, false},
  }};
  return mouths;
}

// The mouth near a usual one, and what its outline teaches of the lips.
MouthStart find_near(const Mouth& usual,
                     const FaceChart& chart,
                     const Evidence& unlearned,
                     double line_cost) {
  MouthStart found;
  found.mouth = find_mouth(unlearned, usual, false, line_cost);
  for (int round = 1; round < kRounds; ++round) {
    const std::vector<Point2> upper = lip_nodes(found.mouth, true);
    if (!found.lips.learn(chart.colour, upper, lip_nodes(found.mouth, false))) break;
    EvidenceOptions places;
    places.mouth_line_px = upper.front().y();
    found.mouth = find_mouth(make_evidence(chart, found.lips, places), usual, true, line_cost);
  }
  return found;
}

cv::Mat inside_of(const Mouth& mouth, const cv::Size& size) {
  return outline_mask(size, mouth_outline(lip_nodes(mouth, true), lip_nodes(mouth, false)));
}

// Colours of a region as a Gaussian.
struct Region {
  double num_pixels = 0.0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  double code_length() const {
    if (num_pixels < 1.0) return 0.0;
    return 0.5 * num_pixels *
           std::log((covariance + kFloor.asDiagonal().toDenseMatrix()).determinant());
  }
};

Region region_of(const cv::Mat& soft, const cv::Mat& mask) {
  Region region;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int row = 0; row < soft.rows; ++row) {
    for (int column = 0; column < soft.cols; ++column) {
      if (mask.at<uchar>(row, column) == 0) continue;
      const Eigen::Vector3d f = colour_features(soft.at<cv::Vec3b>(row, column)).cast<double>();
      sum += f;
      region.covariance += f * f.transpose();
      region.num_pixels += 1.0;
    }
  }
  if (region.num_pixels < 1.0) return region;
  const Eigen::Vector3d mean = sum / region.num_pixels;
  region.covariance = region.covariance / region.num_pixels - mean * mean.transpose();
  return region;
}

cv::Mat with_margin(const cv::Mat& mask) {
  const cv::Size margin(2 * kMargin + 1, 2 * kMargin + 1);
  cv::Mat grown;
  cv::dilate(mask, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, margin));
  return grown;
}

}  // namespace

MouthStart start_mouth(const FaceChart& chart) {
  cv::Mat soft;
  cv::GaussianBlur(chart.colour, soft, cv::Size(), kBlur_px);
  const cv::Mat usual_place = with_margin(inside_of(Mouth(), soft.size()));
  // Without colour, teeth under a lip are bright below a dark line, too.
  const double line_cost = std::min(1.0, region_of(soft, usual_place).covariance(0, 0) / kFloor[0]);
  const Evidence unlearned = make_evidence(chart, LipMap());
  std::vector<MouthStart> found;
  std::vector<cv::Mat> inside;
  cv::Mat picture = cv::Mat::zeros(soft.size(), CV_8U);
  for (const UsualMouth& usual : usual_mouths()) {
    found.push_back(find_near(usual.mouth, chart, unlearned, line_cost));
    inside.push_back(inside_of(found.back().mouth, picture.size()));
    picture |= inside.back();
  }
  picture = with_margin(picture);
  const Region whole = region_of(soft, picture);
  const double hue_variance = whole.covariance(0, 0);
  const double shade = kShade * hue_variance / (hue_variance + kFloor[0]);
  size_t best = 0;
  double least = 0.0;
  for (size_t i = 0; i < found.size(); ++i) {
    const double length = region_of(soft, inside[i]).code_length() +
                          region_of(soft, picture & ~inside[i]).code_length();
    const double cost = length / whole.num_pixels + (usual_mouths()[i].closed ? 0.0 : shade);
    if (i > 0 && cost >= least) continue;
    least = cost;
    best = i;
  }
  MouthStart start = std::move(found[best]);
  start.rest = start.mouth;
  if (!usual_mouths()[best].closed) start.rest.p[Mouth::kLower] = Mouth().p[Mouth::kLower];
  return start;
}

}  // namespace zygoma
