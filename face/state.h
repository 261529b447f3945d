// The part of a face that changes: positions and velocities of all lattice nodes, and what effects
// with memory remember. Surface vertices first, so that the first num_vertices nodes are
// Anatomy::surface.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "face/geometry.h"

namespace zygoma {

struct FaceState {
  double time_s = 0.0;
  double jaw_rad = 0.0;
  std::vector<Vec3> positions_mm;
  std::vector<Vec3> velocities_mm_per_s;               // empty = at rest
  std::map<std::string, std::vector<double>> history;  // by effect
};

}  // namespace zygoma
