// The rings around mouth and eyes as displacements of the surface (muscle.h).
//
// The lips of a closed mouth touch along a line that bends, and lids have a thickness: what a ring
// does there must take a flap along as one piece. So a lip follows its own half of the ring, evenly
// mixed at the corner of the mouth, and a lid moves at every place along the slit by as much as its
// margin has to go to meet the axis.
#pragma once

#include <vector>

#include "face/anatomy.h"

namespace zygoma {

// Blend and displacement of every vertex of the surface at contraction 1.
struct VertexPull {
  std::vector<double> blend;
  std::vector<Vec3> displacement_mm;

  explicit VertexPull(std::size_t num_vertices)
      : blend(num_vertices, 0.0), displacement_mm(num_vertices, Vec3::Zero()) {}
};

// m turned into the plane across `normal`, length kept; a muscle that would run straight into the
// bone is stretched to at most twice its shadow.
Vec3 tangent_with_length(const Vec3& m, const Vec3& normal);

// Per vertex: 0 where the flaps of a slit (lips, lids) meet at its corner, 1 a way off.
std::vector<double> distinct_flaps(const Anatomy& anatomy,
                                   const std::vector<std::vector<int>>& neighbors);

// `normal`: of the head at large; `distinct`: see above.
VertexPull pull_of_ring(const Muscle& muscle,
                        const Anatomy& anatomy,
                        const std::vector<Vec3>& normal,
                        const std::vector<double>& distinct);

// 1 at the rim, 0 in the hole and from the ellipse (r = 1) on.
double ring_blend(const Ring& ring, double r);

}  // namespace zygoma
