// The volume element of the tissue, a triangular prism whose three side faces are bilinear: its
// volume and the derivatives of that.
//
// A side quad can be cut along either diagonal; one choice would favour one side of the face, so
// the mean of both is taken. It equals the volume under the bilinear patch, neighbouring prisms
// share their sides, and volumes add up exactly. With the corner 0 as origin
//
//   12 V = 2 [3,5,4] + [1,3,4] + [2,1,4] + [2,4,5] + [1,4,5] + [1,5,2] + [2,5,3]
//
// where [p,q,r] = p . (q x r); corners 0 1 2 are the upper triangle, counter-clockwise from
// outside, and 3 4 5 lie below them. Every second derivative block is the cross-product matrix of
// a combination of corners.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "face/geometry.h"

namespace zygoma {

// A tetrahedral unit is a prism whose lower corners are one node.
struct Prism {
  std::array<int, 6> node{};  // upper triangle counter-clockwise from outside, then lower
  double rest_mm3 = 0.0;
  double bulk_kpa = 0.0;
};

using PrismCorners = std::array<Vec3, 6>;

inline PrismCorners corners_of(const Prism& prism, const std::vector<Vec3>& positions_mm) {
  PrismCorners corner;
  for (int c = 0; c < 6; ++c) corner[c] = positions_mm[prism.node[c]];
  return corner;
}

inline double prism_volume(const PrismCorners& corner, PrismCorners& gradient) {
  const Vec3 x1 = corner[1] - corner[0];
  const Vec3 x2 = corner[2] - corner[0];
  const Vec3 x3 = corner[3] - corner[0];
  const Vec3 x4 = corner[4] - corner[0];
  const Vec3 x5 = corner[5] - corner[0];
  constexpr double kShare = 1.0 / 12.0;
  const Vec3 x32 = x3 - x2;
  gradient[1] = kShare * (x32.cross(x4) + (x4 - x2).cross(x5));
  gradient[2] = kShare * (x1.cross(x4) + (x4 + x1 - x3).cross(x5));
  gradient[3] = kShare * ((x2 - 2.0 * x4).cross(x5) - x1.cross(x4));
  gradient[4] = kShare * ((x3 + x32 - x1).cross(x5) + x1.cross(x32));
  gradient[5] = kShare * ((x1 - x3 - x32).cross(x4) + x2.cross(x1 - x3));
  gradient[0] = -(gradient[1] + gradient[2] + gradient[3] + gradient[4] + gradient[5]);
  // V is homogeneous of degree 3 in the corners.
  return (x1.dot(gradient[1]) + x2.dot(gradient[2]) + x3.dot(gradient[3]) + x4.dot(gradient[4]) +
          x5.dot(gradient[5])) /
         3.0;
}

// Negative where the prism is inside out.
inline double signed_volume(const PrismCorners& corner) {
  PrismCorners unused;
  return prism_volume(corner, unused);
}
inline double signed_volume(const Prism& prism, const std::vector<Vec3>& positions_mm) {
  return signed_volume(corners_of(prism, positions_mm));
}

// k[p][q], p < q: the second derivative block d(dV/dx_p)/dx_q is the matrix of v -> k x v.
using PrismCurvature = std::array<std::array<Vec3, 6>, 6>;

inline void prism_curvature(const PrismCorners& corner, PrismCurvature& k) {
  const Vec3 x1 = corner[1] - corner[0];
  const Vec3 x2 = corner[2] - corner[0];
  const Vec3 x3 = corner[3] - corner[0];
  const Vec3 x4 = corner[4] - corner[0];
  const Vec3 x5 = corner[5] - corner[0];
  constexpr double kShare = 1.0 / 12.0;
  k[1][2] = kShare * (x4 + x5);
  k[1][3] = -kShare * x4;
  k[1][4] = kShare * (x3 - x2 - x5);
  k[1][5] = kShare * (x4 - x2);
  k[2][3] = kShare * x5;
  k[2][4] = kShare * (x1 - x5);
  k[2][5] = kShare * (x4 + x1 - x3);
  k[3][4] = kShare * (2.0 * x5 - x1);
  k[3][5] = kShare * (x2 - 2.0 * x4);
  k[4][5] = kShare * (2.0 * x3 - x2 - x1);
  // Moving all corners alike changes nothing: every block column sums to zero.
  for (int q = 1; q < 6; ++q) {
    Vec3 sum = Vec3::Zero();
    for (int p = 1; p < q; ++p) sum += k[p][q];
    for (int p = q + 1; p < 6; ++p) sum -= k[q][p];
    k[0][q] = -sum;
  }
}

}  // namespace zygoma
