#include "tracker/evidence.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

// Skin and lips lie about here in the chart; hair, collar and background stay out of the
// statistics.
const cv::Rect kFaceBox(36, 44, 121, 180);
const cv::Rect kLowerFace(36, 140, 121, 110);
constexpr double kLineReach = 9.0;  // chart px above and below the corners of the mouth
const cv::Rect kChinBox(40, 186, 113, 86);
const cv::Rect kHairBox(32, 0, 129, 84);

// Adds to the map how much a pixel lies on a dark horizontal line: the positive second difference
// of the smoothed brightness down the column, its strongest lines set to one. Only near the row of
// the mouth's corners: the fold below the lower lip is a dark line too.
void add_dark_lines(const cv::Mat& grey, double corner_row, cv::Mat& map) {
  cv::Mat smooth, curvature;
  cv::GaussianBlur(grey, smooth, cv::Size(), 2.0, 1.4);
  smooth.convertTo(smooth, CV_32F);
  curvature.create(smooth.size(), CV_32F);
  for (int row = 0; row < smooth.rows; ++row) {
    const float* above = smooth.ptr<float>(std::max(0, row - 2));
    const float* here = smooth.ptr<float>(row);
    const float* below = smooth.ptr<float>(std::min(smooth.rows - 1, row + 2));
    float* out = curvature.ptr<float>(row);
    for (int i = 0; i < smooth.cols; ++i) out[i] = 0.25F * (above[i] + below[i]) - 0.5F * here[i];
  }
  std::vector<float> sorted;  // every other pixel of every other row
  for (int row = 0; row < curvature.rows; row += 2) {
    const float* line = curvature.ptr<float>(row);
    for (int column = 0; column < curvature.cols; column += 2) sorted.push_back(line[column]);
  }
  const auto at =
      sorted.begin() + static_cast<std::ptrdiff_t>(0.97 * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), at, sorted.end());
  const float unit = 255.0F / std::max(0.75F, *at);
  const int first = std::clamp(static_cast<int>(corner_row - kLineReach), 0, map.rows);
  const int last = std::clamp(static_cast<int>(corner_row + kLineReach), 0, map.rows);
  for (int row = first; row < last; ++row) {
    const float* line = curvature.ptr<float>(row);
    float* out = map.ptr<float>(row);
    for (int column = 0; column < map.cols; ++column) {
      out[column] = std::max(out[column], std::min(255.0F, unit * line[column]));
    }
  }
}

// Closes the mouth: what lies in a column between two strong responses, one above and one below and
// not too far apart, is between the lips, be it teeth.
void fill(cv::Mat& map, int first_row) {
  constexpr float kStrong = 150.0F;
  constexpr int kWidest = 24;  // chart px
  std::vector<int> last_strong(static_cast<size_t>(map.cols), -kWidest - 1);
  for (int row = std::max(0, first_row); row < map.rows; ++row) {
    const float* line = map.ptr<float>(row);
    for (int column = 0; column < map.cols; ++column) {
      if (line[column] < kStrong) continue;
      int& above = last_strong[static_cast<size_t>(column)];
      if (row - above <= kWidest) {
        for (int r = above + 1; r < row; ++r) map.at<float>(r, column) = kStrong;
      }
      above = row;
    }
  }
}

// Sums down the columns, in units of one: row r holds the sum of the rows above it.
cv::Mat column_sums(const cv::Mat& map) {
  cv::Mat sums(map.rows + 1, map.cols, CV_32F, cv::Scalar(0.0));
  for (int row = 0; row < map.rows; ++row) {
    const float* in = map.ptr<float>(row);
    const float* above = sums.ptr<float>(row);
    float* out = sums.ptr<float>(row + 1);
    for (int column = 0; column < map.cols; ++column) {
      out[column] = above[column] + in[column] / 255.0F;
    }
  }
  return sums;
}

// Unit normal to the right of the walk in picture coordinates (y down), made to point downwards.
Point2 downward_normal(const std::vector<Point2>& nodes, size_t i) {
  const Point2 along = nodes[std::min(i + 1, nodes.size() - 1)] - nodes[i > 0 ? i - 1 : 0];
  const double length = along.norm();
  if (length < 1e-6) return {0.0, 1.0};
  const double sign = along.x() < 0.0 ? -1.0 : 1.0;
  return sign / length * Point2(-along.y(), along.x());
}

}  // namespace

double Evidence::lip_column(double x, double top, double bottom) const {
  const int column = static_cast<int>(std::lround(x)) - kLowerFace.x;
  if (!(bottom > top) || column < 0 || column >= lip_sums.cols) return 0.0;
  // Pixel r covers [r - 1/2, r + 1/2]: its upper border is row r of the sums.
  const auto above = [&](double y) {
    const double row = std::clamp(y - kLowerFace.y + 0.5, 0.0, lip_sums.rows - 1.001);
    const int r = static_cast<int>(row);
    const double u = row - r;
    return (1.0 - u) * static_cast<double>(lip_sums.at<float>(r, column)) +
           u * static_cast<double>(lip_sums.at<float>(r + 1, column));
  };
  return above(bottom) - above(top);
}

Evidence make_evidence(const FaceChart& chart, const LipMap& lips, const EvidenceOptions& options) {
  Evidence evidence;
  evidence.fine = PotentialField(chart.grey, kFaceBox, {options.fine_sigma_px, 0.95, 1.0});
  evidence.chin = PotentialField(chart.grey, kChinBox, {options.coarse_sigma_px, 0.95, 1.0, 2});
  evidence.hair = PotentialField(chart.grey, kHairBox, {options.coarse_sigma_px, 0.95, 1.0, 2});
  cv::Mat map(chart.grey.size(), CV_32F, cv::Scalar(0.0));
  cv::Mat mouth = map(kLowerFace);
  lips.apply(chart.colour(kLowerFace)).copyTo(mouth);
  if (lips.learned()) {
    add_dark_lines(chart.grey(kLowerFace), options.mouth_line_px - kLowerFace.y, mouth);
    const double first_row = options.nose_base_px + 0.02 * kChartEyeDistance - kLowerFace.y;
    fill(mouth, static_cast<int>(first_row));
    evidence.lip_sums = column_sums(mouth);
  }
  evidence.lips = PotentialField(map, kLowerFace, {options.lips_sigma_px, 0.95, 0.15});
  return evidence;
}

namespace {

EvidenceTerms evidence_terms(const Evidence& evidence, FeatureIndex feature) {
  using Term = EvidenceTerm;
  switch (feature) {
    case kBrowLeft:
    case kBrowRight:
    case kEyelidLeft:
    case kEyelidRight:
      return {Term{&evidence.fine, 1.0, -1.0}};
    case kNoseTip:
      return {Term{&evidence.fine, 1.0, 1.0}};
    case kUpperLip:
      return {Term{&evidence.lips, 0.65, 1.0}, Term{&evidence.fine, 0.35, -1.0}};
    case kLowerLip:
      return {Term{&evidence.lips, 0.75, -1.0}, Term{&evidence.fine, 0.25, 1.0}};
    case kFurrowLeft:
    case kFurrowRight:
      return {Term{&evidence.fine, 0.5, 0.0}};
    case kChinBoss:
      return {Term{&evidence.chin, 1.0, -1.0}};
    case kHairline:
      return {Term{&evidence.hair, 1.0, 0.0}};
    case kNumFeatures:
      break;
  }
  return {};
}

double potential_of(const EvidenceTerms& terms, const Point2& x, const Point2& normal) {
  double sum = 0.0;
  for (const EvidenceTerm& term : terms) {
    if (term.field == nullptr) break;
    sum += term.weight * (term.sign == 0.0 ? term.field->potential(x)
                                           : term.field->potential(x, term.sign * normal));
  }
  return sum;
}

}  // namespace

ContourLandscape::ContourLandscape(const Evidence& evidence,
                                   FeatureIndex feature,
                                   const std::vector<Point2>& nodes)
    : terms_(evidence_terms(evidence, feature)) {
  for (size_t i = 0; i < nodes.size(); ++i) normals_.push_back(downward_normal(nodes, i));
}

double ContourLandscape::potential(size_t node, const Point2& x) const {
  return potential_of(terms_, x, normals_[node]);
}

Point2 ContourLandscape::gradient(size_t node, const Point2& x) const {
  Point2 sum = Point2::Zero();
  for (const EvidenceTerm& term : terms_) {
    if (term.field == nullptr) break;
    sum += term.weight * (term.sign == 0.0 ? term.field->gradient(x)
                                           : term.field->gradient(x, term.sign * normals_[node]));
  }
  return sum;
}

double evidence_under(const Evidence& evidence,
                      FeatureIndex feature,
                      const std::vector<Point2>& nodes) {
  const EvidenceTerms terms = evidence_terms(evidence, feature);
  double sum = 0.0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    sum -= potential_of(terms, nodes[i], downward_normal(nodes, i));
  }
  return nodes.empty() ? 0.0 : sum / static_cast<double>(nodes.size());
}

}  // namespace zygoma
