// The head frame: the similarity (shift, roll, scale) that carries one picture of the face onto
// another, read from parts that do not move with expression.
//
// Every displacement a muscle could explain is measured after this motion has been taken off, so a
// point that does move (an eyebrow, a blinking lid) must not bend the fit. The start is the pair of
// points whose similarity has the least median error over all others; a few rounds of re-weighted
// least squares with Tukey's weights (zero beyond a few times the spread) then use all good points.
// No random numbers: the same points give the same bits.
#pragma once

#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

// x -> [a -b; b a] x + shift.
struct Similarity {
  double a = 1.0;
  double b = 0.0;
  Point2 shift = Point2::Zero();

  Point2 apply(const Point2& x) const {
    return {a * x.x() - b * x.y() + shift.x(), b * x.x() + a * x.y() + shift.y()};
  }
  double scale() const;
  Similarity inverse() const;
  // First `inner`, then this one.
  Similarity after(const Similarity& inner) const;
};

// The similarity that maps two points exactly; identity if they coincide.
Similarity similarity_from_pair(const Point2& from_a,
                                const Point2& from_b,
                                const Point2& to_a,
                                const Point2& to_b);

struct HeadFrameFit {
  Similarity similarity;
  double inlier_share = 0.0;  // of the points given
  double rms_px = 0.0;        // of the inliers
  bool ok = false;            // at least four inliers, spread out, scale sane
};

// The robust fit from -> to. The vectors have equal length; errors below `noise_px` all count as
// good.
HeadFrameFit fit_head_frame(const std::vector<Point2>& from,
                            const std::vector<Point2>& to,
                            double noise_px = 0.25);

}  // namespace zygoma
