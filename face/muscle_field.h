// What the muscles of a face ask of its fascia (paper, equations (3) and (4)).
//
//   t_j(c) = X_j + sum_i c_i s_i b_ij m_ij,     b_ij = cos(pi/2 d_ij / a_i)
//
// d_ij is the distance along the skin from the attachment of muscle i to column j, so that it leads
// around the mouth, not across. Of the two flaps of a slit (lips, lids) a muscle reaches only the
// nearer one unless it attaches at their corner. m_ij is m_i in the tangent plane of a broadly
// smoothed surface at j, with its length kept. Rings: see muscle.h; those that are halved share the
// middle smoothly, so that both halves together are the whole ring.
//
// The sum is linear and over the rest position: the order of the muscles has no effect.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/lattice.h"

namespace zygoma {

struct MusclePull {
  int column = 0;
  double blend = 0.0;    // b_ij, (0, 1]
  Vec3 displacement_mm;  // s_i b_ij m_ij: where contraction 1 moves the fascia
};

struct MuscleField {
  std::vector<std::vector<MusclePull>> pulls;  // per muscle, columns on bone, ascending
  std::vector<double> hold;                    // per column: w_j = max_i b_ij
};

// Throws InputError naming the muscle if one has no length, no reach or a value that is not finite.
MuscleField make_muscle_field(const Anatomy& anatomy, const Lattice& lattice);

// s ||m|| pi / (2 a): from 1 on, one muscle alone folds the tissue over at contraction 1. Of a ring
// the largest compression on its axes.
double fold_measure(const Muscle& muscle);

// Triangles of the surface that the targets of these contractions turn over or squeeze to nothing:
// where this is not 0, muscles ask together for what tissue cannot do. Lids do not count, which
// turn about the eyeball.
int num_folded(const Anatomy& anatomy,
               const MuscleField& field,
               const std::vector<double>& contraction);

// Distance along the surface from a point on it to every vertex within `reach_mm` (others are
// infinite). Exact on flat pieces: every triangle unfolds the wave front that crosses its far edge.
std::vector<double> distance_along(const SurfaceMesh& surface,
                                   const Vec3& from_mm,
                                   double reach_mm);

// The same from a set of vertices (mask per vertex).
std::vector<double> distance_along(const SurfaceMesh& surface,
                                   const std::vector<char>& from,
                                   double reach_mm);

}  // namespace zygoma
