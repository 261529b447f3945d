// How the picture of the neutral head moves when the head does: a similarity in the image, a turn
// and a nod out of it, under weak or full perspective.
//
// A node seen at q (mm at the depth of the pupils, x right, y down) and known to lie at the depth z
// (towards the viewer) of the upright head stands at (x, y, z), (x, y) = q / m(z). With the nod
// theta (the face turns downwards), the turn psi (to the image's right), the roll phi, the scale
// e^s and the shift t it is seen at
//
//   p = e^s m(e^s z') R(phi) (x', y') + t,       m(z) = 1 / (1 - z / D)
//   y1 = y cos theta + z sin theta,  z1 = z cos theta - y sin theta
//   x' = x cos psi + z1 sin psi,     z' = z1 cos psi - x sin psi,   y' = y1.
//
// D is the distance of the camera from the neutral head: focal length (px) times mm per px. An
// infinite D is weak perspective, m = 1.
#pragma once

#include <Eigen/Core>

#include "retarget/head_motion.h"

namespace zygoma {

class HeadView {
 public:
  static constexpr int kNumParameters = 6;
  using Parameters = Eigen::Matrix<double, kNumParameters, 1>;  // s, phi, t_x, t_y, psi, theta

  explicit HeadView(const Parameters& head, double inverse_distance_per_mm = 0.0);

  // Where a node is seen, and the derivatives by q and by the parameters.
  struct Sight {
    Point2 at;
    Eigen::Matrix2d by_node;
    Eigen::Matrix<double, 2, kNumParameters> by_head;
  };

  Sight see(const Point2& q, double depth_mm) const;

 private:
  double inverse_distance_;  // 1 / D
  double scale_;
  Point2 shift_;
  Eigen::Matrix2d roll_;
  double cos_yaw_, sin_yaw_;
  double cos_pitch_, sin_pitch_;
};

// Of the parameters, what the image alone shows.
HeadMotion similarity_of(const HeadView::Parameters& head);

}  // namespace zygoma
