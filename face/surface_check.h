// Whether a triangle mesh from outside can carry tissue; what can be repaired without guessing is.
//
// Repaired: vertices that coincide become one (except across a slit: closed lips stay apart);
// triangles without area and vertices without triangle are dropped, where a vertex lies on a
// neighbour's edge that edge is flipped; a piece that is inside out is turned. Rejected, with a
// message that names the element: coordinates that are not finite, a size that is no face's in
// millimetres, edges and vertices where the surface is no surface, triangles that disagree about
// which side is outside, slivers, and a second piece unless allowed. Holes are fine: a face has
// mouth, eyes, nostrils and a border at the neck.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/geometry.h"

namespace zygoma {

struct SurfaceCheckOptions {
  bool several_pieces = false;
  double coincident_mm = 1e-6;     // vertices closer than this are one
  double largest_aspect = 1000.0;  // longest edge over height of a triangle
};

struct CheckedSurface {
  SurfaceMesh mesh;
  std::vector<int> vertex_of;  // per vertex of the input its place in `mesh`, -1 = dropped
  int merged_vertices = 0;
  int dropped_vertices = 0;  // without triangle
  int dropped_triangles = 0;
  int flipped_edges = 0;
  int turned_pieces = 0;
  int pieces = 0;
  int borders = 0;  // holes and outer borders
};

// `region`: per vertex, or empty. Coincident vertices of the two flaps of a slit are not merged.
// Throws InputError.
CheckedSurface checked_surface(const SurfaceMesh& surface,
                               const std::vector<Region>& region = {},
                               const SurfaceCheckOptions& options = {});

}  // namespace zygoma
