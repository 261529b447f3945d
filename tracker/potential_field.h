// The image as a landscape for snakes (paper, equation 9): P = -|grad(G_sigma * I)|, whose ravines
// are the edges of I, and beside it the signed form P_n = -max(0, n . grad(G_sigma * I)).
//
// The unsigned potential cannot tell the two sides of a dark brow, or of a lip, apart: both are
// equal ravines, and a snake changes from one to the other. Where a feature's polarity is known the
// signed form has only the right ravine.
//
// The smoothed gradient is computed once, only in the region asked for, and divided by a high
// percentile of its magnitude there, so that the weight of the image means the same on every clip
// and at every exposure. Values between pixels are bilinear in the *gradient of P*; outside the
// region (less one pixel) everything is zero.
#pragma once

#include <opencv2/core.hpp>

#include "tracker/contour_set.h"

namespace zygoma {

struct PotentialOptions {
  double sigma_px = 1.5;     // of the Gaussian; [0.5, 8]. Attracts from about two sigma.
  double percentile = 0.95;  // of the gradient magnitude that becomes one; (0, 1]
  double floor = 1.0;  // grey levels per px: a flatter region is not blown up to that percentile
  int shrink = 1;      // the image is shrunk by this first; a wide Gaussian loses nothing by it
};

class PotentialField {
 public:
  PotentialField() = default;
  // `image` is one channel, 8-bit or float; the region is cut to it.
  PotentialField(const cv::Mat& image, const cv::Rect& region, const PotentialOptions& options);

  bool contains(const Point2& x) const;
  // The normalised gradient of the smoothed image.
  Point2 image_gradient(const Point2& x) const;
  // P and its gradient, without sign.
  double potential(const Point2& x) const;
  Point2 gradient(const Point2& x) const;
  // P_n and its gradient for a unit normal n pointing up the wanted gradient.
  double potential(const Point2& x, const Point2& normal) const;
  Point2 gradient(const Point2& x, const Point2& normal) const;

 private:
  // Place in the shrunk region.
  Point2 place_of(const Point2& x) const;
  bool holds(const Point2& place) const;
  Point2 gradient_at(const Point2& place) const;

  double scale_ = 1.0;              // of the shrunk region
  Point2 offset_ = Point2::Zero();  // place = scale x + offset
  Point2 end_ = Point2::Zero();     // places are before it
  cv::Mat gradient_x_;              // float, grey levels per px of the shrunk region
  cv::Mat gradient_y_;
  cv::Mat magnitude_;
  double unit_ = 1.0;  // from that to the normalised gradient
};

}  // namespace zygoma
