// A linear facial muscle after Waters & Terzopoulos 1992, section 4, equations (3) and (4).
//
//   x'_j = x_j + sum_i c_i s_i b_ij m_ij,   b_ij = cos(pi/2 d_ij / a_i) for d_ij <= a_i, else 0
//
// m_i = emergence - attachment points from the tissue to the bone, a_i is the radius of influence
// around the attachment, c_i in [0, 1] the contraction and s_i the largest shortening, so that
// c_i = 1 is the strongest contraction the muscle is capable of. Two points of the print are
// changed: the distance d_ij is measured along the skin, not through it (else the upper lip's
// muscle drags the lower lip), and m_i is turned into the tangent plane at node j with its length
// kept (a chord cuts through a convex skull).
#pragma once

#include <string>

#include "face/geometry.h"

namespace zygoma {

struct Muscle {
  std::string name;               // "zygomaticus_major_L"; _L and _R are the subject's sides
  Vec3 attachment_mm;             // skin end m^a, on the epidermis at rest
  Vec3 emergence_mm;              // bone end m^e
  double radius_mm = 0.0;         // a: radius of influence, along the skin
  double largest_shortening = 0;  // s: share of ||m|| at contraction 1
};

}  // namespace zygoma
