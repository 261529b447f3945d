#include "tracker/scene_cut.h"

#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

const cv::Size kLook(32, 18);
constexpr double kBlack = 6.0;       // grey levels, mean
constexpr double kLeastCut = 0.15;   // difference, shares of the mean
constexpr double kAboveUsual = 5.0;  // times the usual difference
constexpr double kForget = 0.2;      // per frame

}  // namespace

bool SceneCut::at(const Picture& picture) {
  if (picture.empty()) return false;
  cv::Mat small, look;
  const cv::Mat sparse = picture.sparse(kLook * 2);  // a few pixels speak for the others
  cv::resize(sparse, small, kLook, 0, 0, cv::INTER_AREA);
  const cv::Scalar mean = cv::mean(small);
  const double level = (mean[0] + mean[1] + mean[2]) / 3.0;
  if (level < kBlack) return false;
  small.convertTo(look, CV_32F, 1.0 / level);
  const cv::Mat before = last_;
  last_ = look;
  if (before.empty()) return false;
  const double change =
      cv::norm(look, before, cv::NORM_L1) / (3.0 * static_cast<double>(look.total()));
  const bool cut = change > kLeastCut && change > kAboveUsual * usual_;
  usual_ += kForget * (change - usual_);
  return cut;
}

}  // namespace zygoma
