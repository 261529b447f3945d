// Where the head is in the image: a similarity (shift, roll, scale) against the neutral frame,
// fitted to the parts that do not move with the expression (paper, section 6c: the hairline is the
// head reference; the nose tip is our second one, as a mean alone cannot see roll or scale; where
// lids are tracked, the corners of the eyes are the best there is).
//
// Minimises sum_k w_k rho(||S(p_k) - q_k||) with Cauchy's rho by reweighting; each weighted step is
// closed form. A tracked hairline is often disturbed by hair, so no contour is trusted alone.
#pragma once

#include <Eigen/Core>

#include "retarget/correspondence.h"

namespace zygoma {

// x' = (a x - b y + t_x, b x + a y + t_y); with y down, a positive roll is clockwise on the screen.
struct HeadMotion {
  double a = 1.0;
  double b = 0.0;
  Point2 shift{0.0, 0.0};

  Point2 operator*(const Point2& p) const {
    return {a * p.x() - b * p.y() + shift.x(), b * p.x() + a * p.y() + shift.y()};
  }
  HeadMotion operator*(const HeadMotion& second) const;  // this after second
  HeadMotion inverse() const;
  double scale() const;
  double roll_rad() const;
};

// Weighted least squares; identity plus shift when all weighted points coincide.
HeadMotion fit_head_motion(const NodeStack& from,
                           const NodeStack& to,
                           const Eigen::VectorXd& weight);

// The same with outliers beyond a few `scale` (units of `to`) fading out.
HeadMotion fit_head_motion_robustly(const NodeStack& from,
                                    const NodeStack& to,
                                    const Eigen::VectorXd& weight,
                                    double outlier_scale);

// How much each node says about the head in a pair of frames: corners of the eyes, hairline and
// nose tip; outer brow ends, furrow tops and mouth corners a little, for frames in which the others
// are lost.
Eigen::VectorXd head_weights(const StackedContours& neutral, const StackedContours& frame);

}  // namespace zygoma
