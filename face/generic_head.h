// The embedded default face: a human head authored as a compact description (profile and
// cross-section curves, feature parameters), evaluated at any resolution.
#pragma once

#include <cstdint>

#include "face/anatomy.h"

namespace zygoma {

// Shape of one person against the default head. All are ratios around 1 unless the unit says so.
struct Identity {
  double face_width = 1.0;
  double face_height = 1.0;
  double jaw_width = 1.0;
  double nose_length = 1.0;
  double nose_width = 1.0;
  double lip_fullness = 1.0;
  double brow_height_mm = 0.0;  // + raises the brows
  double eye_distance = 1.0;
  double chin_length = 1.0;
  Eigen::Vector3f skin_tone{0.80F, 0.58F, 0.46F};  // sRGB
  Eigen::Vector3f hair_tone{0.16F, 0.11F, 0.08F};
  double stubble = 0.0;            // of the beard, [0, 1]
  std::uint32_t texture_seed = 1;  // freckles, brow hairs, blotches

  // Throws InputError naming the first value outside its range.
  void check() const;
};

struct HeadOptions {
  int num_surface_vertices = 300;  // of the lattice surface, met approximately; [300, 4000]
  int skin_levels = 2;             // subdivisions from surface to skin, [0, 3]
  int albedo_size_px = 768;        // painted skin, square, [64, 4096]; below 512 brows blur

  void check() const;  // throws InputError naming the value outside its range
};

Anatomy make_generic_head(const Identity& identity = {}, const HeadOptions& options = {});

}  // namespace zygoma
