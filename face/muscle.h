// A facial muscle after Waters & Terzopoulos 1992, section 4, equations (3) and (4).
//
//   x'_j = x_j + sum_i c_i s_i b_ij m_ij,   b_ij = cos(pi/2 d_ij / a_i) for d_ij <= a_i, else 0
//
// m_i = emergence - attachment points from the tissue to the bone, a_i is the radius of influence
// around the attachment, c_i in [0, 1] the contraction and s_i the largest shortening, so that
// c_i = 1 is the strongest contraction the muscle is capable of. Two points of the print are
// changed: the distance d_ij is measured along the skin, not through it (else the upper lip's
// muscle drags the lower lip), and m_i is turned into the tangent plane at node j with its length
// kept (a chord cuts through a convex skull).
//
// The rings around mouth and eyes pull towards an axis instead of a bone (Waters 1987): with p the
// place relative to the ring's centre, u along it and v across it,
//
//   m_ij = - along (p.u) u - across (p.v) v,    and f forward,
//
// and b_ij is 1 at the rim and falls to 0, as a raised cosine, inwards on the hole and outwards on
// the ellipse of half length a. Of two lips that touch, both sides of the slit go to the same
// place: a ring cannot push one through the other.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "face/geometry.h"

namespace zygoma {

// What makes a muscle a ring around the attachment, its half length from there to the emergence.
struct Ring {
  Vec3 forward = Vec3::UnitZ();  // across the plane of the ring, outwards
  double aspect = 1.0;           // half width / half length
  double hole = 0.0;             // shares of the ellipse: nothing moves within the hole, all moves
  double rim = 0.3;              // in full at the rim; 0 = no hole. hole < rim < 1
  double along = 1.0;            // shares of s by which it narrows, [-1, 1]; negative: widens
  double across = 1.0;
  double forward_mm = 0.0;  // f s: of the rim, at contraction 1
  int side = 0;             // +1 only the subject's left half, -1 the right one
  int flap = 0;             // +1 only the upper half, -1 the lower one
  // Tissue that lies on a ball (an eye) turns about its centre instead of going straight.
  std::optional<Vec3> pivot_mm;
};

struct Muscle {
  std::string name;               // "zygomaticus_major_L"; _L and _R are the subject's sides
  Vec3 attachment_mm;             // skin end m^a, on the epidermis at rest
  Vec3 emergence_mm;              // bone end m^e
  double radius_mm = 0.0;         // a: radius of influence, along the skin
  double largest_shortening = 0;  // s: share of ||m|| at contraction 1
  double scalp_share = 0.0;  // of its pull, by which the scalp gives way where that is the other
                             // end; 0 = bone
  std::optional<Ring> ring = std::nullopt;
};

inline bool has_side(std::string_view muscle) {
  return muscle.ends_with("_L") || muscle.ends_with("_R");
}

// What both muscles of a pair are called.
inline std::string_view without_side(std::string_view muscle) {
  return has_side(muscle) ? muscle.substr(0, muscle.size() - 2) : muscle;
}

}  // namespace zygoma
