// Meshes the head's domain: a graded triangulation of the right half (X >= 0), mirrored exactly.
//
// Border points first (rims of mouth and eye with a ring around them, midline, outline), then the
// inside is filled with a Poisson-disk pattern of graded spacing and relaxed by springs over its
// own Delaunay triangulation (Persson and Strang's way to smooth meshes). A strip of inner lip and
// lid margin is sewn to the rims afterwards.
#pragma once

#include <vector>

#include "face/head_shape.h"

namespace zygoma {

struct DomainMesh {
  std::vector<DomainPoint> points;
  std::vector<Triangle> triangles;
  std::vector<int> mirror;  // the vertex on the other side; itself on the midline
};

// About num_vertices vertices in all.
DomainMesh mesh_domain(const HeadShape& shape, int num_vertices);

// The outline of the domain, X >= 0: s in [0, 1] from the crown to the side of the neck.
Vec2 outline_point(double s);

// One step of subdivision, 1 triangle into 4: even vertices first, then one per edge. `stencils`
// says how a displacement goes from old to new vertices (Loop's smooth weights, border edges on
// their own).
struct StencilEntry {
  int vertex;
  double weight;
};
using Stencil = std::vector<StencilEntry>;
DomainMesh subdivide(const HeadShape& shape,
                     const DomainMesh& mesh,
                     std::vector<Stencil>& stencils);

}  // namespace zygoma
