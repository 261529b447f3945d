// A picture of the mouth in which the outer border of the lips is the only strong edge.
//
// Colour alone has edges on both sides of each lip, at the teeth and at the tongue, and a snake on
// the outer border steps over to them when the mouth opens. But the outer border is the one where
// *skin* ends. So the skin around the mouth is learned for this face and light: a Gaussian over
// (pseudo-hue, blue share, brightness). The map is how much a pixel is not that skin,
//   m = 1 - exp(-d^2 / 2 c^2),  d: Mahalanobis distance,
// with c such that the lips of the learned picture reach 0.85. It saturates, so lips, teeth and the
// dark of the open mouth look the same, and what is left is the border wanted.
//
// Before anything is learned the map is the pseudo-hue R/(R+G) itself.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

// Around the mouth and back to where it began.
std::vector<Point2> mouth_outline(const std::vector<Point2>& upper_lip,
                                  const std::vector<Point2>& lower_lip);
// What lies within an outline grown about its middle by a factor and so many px more.
cv::Mat outline_mask(const cv::Size& size,
                     const std::vector<Point2>& outline,
                     double factor = 1.0,
                     double more_px = 0.0);

// Pseudo-hue, share of blue, brightness of a pixel, all about [0, 1]. Near-black pixels, whose
// colour is noise, come out neutral.
Eigen::Vector3f colour_features(const cv::Vec3b& bgr);

class LipMap {
 public:
  // Learns skin from the ring about the mouth and c from the lips; chart pixels. False, and
  // unchanged, if there is too little to learn from or lips do not differ from skin at all.
  bool learn(const cv::Mat& bgr,
             const std::vector<Point2>& upper_lip,
             const std::vector<Point2>& lower_lip);
  bool learned() const { return learned_; }

  // The map of a part of the chart, float, [0, 255].
  cv::Mat apply(const cv::Mat& bgr) const;

 private:
  bool learned_ = false;
  Eigen::Vector3f mean_ = Eigen::Vector3f::Zero();
  Eigen::Matrix3f whiten_ = Eigen::Matrix3f::Identity();  // L^-1 of the covariance L L^T
  float scale_ = 1.0F;                                    // c
};

}  // namespace zygoma
