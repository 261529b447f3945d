#include "tracker/predictor.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <opencv2/video/tracking.hpp>

namespace zygoma {
namespace {

constexpr double kBackwardScale = 0.7;  // chart px of forward-backward error that cost 63 % quality
constexpr double kFarMove = 24.0;       // chart px from the guess: not the same point any more

std::vector<cv::Point2f> to_float(const std::vector<Point2>& points) {
  std::vector<cv::Point2f> out;
  out.reserve(points.size());
  for (const Point2& p : points) {
    out.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return out;
}

}  // namespace

Flow follow_points(const std::vector<cv::Mat>& first,
                   const std::vector<cv::Mat>& second,
                   const std::vector<Point2>& from,
                   const std::vector<Point2>& guess,
                   bool check,
                   int levels) {
  assert(from.size() == guess.size());
  Flow flow{guess, std::vector<double>(from.size(), 0.0)};
  if (from.empty()) return flow;
  const std::vector<cv::Point2f> start = to_float(from);
  std::vector<cv::Point2f> there = to_float(guess);
  std::vector<cv::Point2f> back = start;
  std::vector<unsigned char> found_there, found_back;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.03);
  cv::calcOpticalFlowPyrLK(first,
                           second,
                           start,
                           there,
                           found_there,
                           cv::noArray(),
                           kFlowWindow,
                           levels,
                           stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW,
                           1e-4);
  if (check) {
    // On the finest level alone and not for long: it starts where it should end.
    const cv::TermCriteria near(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 5, 0.03);
    cv::calcOpticalFlowPyrLK(second,
                             first,
                             there,
                             back,
                             found_back,
                             cv::noArray(),
                             kFlowWindow,
                             0,
                             near,
                             cv::OPTFLOW_USE_INITIAL_FLOW,
                             1e-4);
  }
  for (size_t i = 0; i < from.size(); ++i) {
    const Point2 p{there[i].x, there[i].y};
    if (!found_there[i] || (check && !found_back[i]) || !p.allFinite()) continue;
    if ((p - guess[i]).norm() > kFarMove) continue;
    const double miss = std::hypot(back[i].x - start[i].x, back[i].y - start[i].y);
    if (!std::isfinite(miss)) continue;
    flow.points_px[i] = p;
    flow.quality[i] = std::exp(-miss * miss / (kBackwardScale * kBackwardScale));
  }
  return flow;
}

}  // namespace zygoma
