// The part of a face that changes: positions of all lattice nodes. Layer by layer, epidermis
// first, so that the first num_surface_vertices nodes are Anatomy::surface.
#pragma once

#include <vector>

#include "face/geometry.h"

namespace zygoma {

struct FaceState {
  double time_s = 0.0;
  double jaw_rad = 0.0;
  std::vector<Vec3> positions_mm;
};

}  // namespace zygoma
