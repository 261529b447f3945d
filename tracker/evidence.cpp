#include "tracker/evidence.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

// Skin and lips lie about here in the chart; hair, collar and background stay out of the
// statistics.
const cv::Rect kFaceBox(36, 44, 121, 180);
const cv::Rect kLowerFace(36, 140, 121, 110);
const cv::Rect kWholeChart(0, 0, kChartWidth, kChartHeight);

cv::Mat pseudo_hue(const cv::Mat& bgr) {
  cv::Mat hue(bgr.size(), CV_32F);
  for (int row = 0; row < bgr.rows; ++row) {
    const cv::Vec3b* in = bgr.ptr<cv::Vec3b>(row);
    float* out = hue.ptr<float>(row);
    for (int column = 0; column < bgr.cols; ++column) {
      const float red = in[column][2];
      // The constant keeps near-black pixels, whose hue is noise, near the neutral one half.
      out[column] = 255.0F * (red + 8.0F) / (red + static_cast<float>(in[column][1]) + 16.0F);
    }
  }
  return hue;
}

// Unit normals to the right of the walk in picture coordinates (y down), made to point downwards.
std::vector<Point2> downward_normals(const std::vector<Point2>& nodes) {
  std::vector<Point2> normals(nodes.size(), Point2(0.0, 1.0));
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Point2 along = nodes[std::min(i + 1, nodes.size() - 1)] - nodes[i > 0 ? i - 1 : 0];
    const double length = along.norm();
    if (length < 1e-6) continue;
    Point2 normal{-along.y() / length, along.x() / length};
    if (normal.y() < 0.0) normal = -normal;
    normals[i] = normal;
  }
  return normals;
}

}  // namespace

Evidence make_evidence(const FaceChart& chart, const EvidenceOptions& options) {
  Evidence evidence;
  evidence.fine = PotentialField(chart.grey, kFaceBox, {options.fine_sigma_px, 0.95, 1.0});
  evidence.coarse = PotentialField(chart.grey, kWholeChart, {options.coarse_sigma_px, 0.95, 1.0});
  const cv::Mat hue = pseudo_hue(chart.colour(kLowerFace));
  cv::Mat placed(chart.grey.size(), CV_32F, cv::Scalar(127.5));
  hue.copyTo(placed(kLowerFace));
  evidence.lips = PotentialField(placed, kLowerFace, {options.lips_sigma_px, 0.95, 0.15});
  return evidence;
}

ContourLandscape::ContourLandscape(const Evidence& evidence,
                                   FeatureIndex feature,
                                   const std::vector<Point2>& nodes)
    : normals_(downward_normals(nodes)) {
  switch (feature) {
    case kBrowLeft:
    case kBrowRight:
    case kNoseTip:
      terms_ = {{&evidence.fine, 1.0, -1.0}};
      break;
    case kUpperLip:
      terms_ = {{&evidence.lips, 0.65, 1.0}, {&evidence.fine, 0.35, -1.0}};
      break;
    case kLowerLip:
      terms_ = {{&evidence.lips, 0.75, -1.0}, {&evidence.fine, 0.25, 1.0}};
      break;
    case kFurrowLeft:
    case kFurrowRight:
      terms_ = {{&evidence.fine, 0.5, 0.0}};
      break;
    case kChinBoss:
      terms_ = {{&evidence.coarse, 1.0, -1.0}};
      break;
    case kHairline:
      terms_ = {{&evidence.coarse, 1.0, 0.0}};
      break;
    case kNumFeatures:
      break;
  }
}

double ContourLandscape::potential(size_t node, const Point2& x) const {
  double sum = 0.0;
  for (const Term& term : terms_) {
    sum += term.weight * (term.sign == 0.0 ? term.field->potential(x)
                                           : term.field->potential(x, term.sign * normals_[node]));
  }
  return sum;
}

Point2 ContourLandscape::gradient(size_t node, const Point2& x) const {
  Point2 sum = Point2::Zero();
  for (const Term& term : terms_) {
    sum += term.weight * (term.sign == 0.0 ? term.field->gradient(x)
                                           : term.field->gradient(x, term.sign * normals_[node]));
  }
  return sum;
}

double evidence_under(const Evidence& evidence,
                      FeatureIndex feature,
                      const std::vector<Point2>& nodes) {
  const ContourLandscape landscape(evidence, feature, nodes);
  double sum = 0.0;
  for (size_t i = 0; i < nodes.size(); ++i) sum -= landscape.potential(i, nodes[i]);
  return nodes.empty() ? 0.0 : sum / static_cast<double>(nodes.size());
}

}  // namespace zygoma
