// Who performs and where: identity, light, background and the slow sway of the head, all drawn from
// one seed within the range of ordinary people and rooms.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "face/generic_head.h"
#include "src/render/renderer.h"

namespace zygoma {

Identity draw_identity(std::uint32_t seed);
Lighting draw_lighting(std::uint32_t seed);

// A few slow sines per axis: people do not hold their head still.
class Sway {
 public:
  // `amount` 1 = a few degrees and about a centimetre.
  Sway(std::uint32_t seed, double amount);

  // The head against its upright place at a time; turns about the top of the neck.
  Eigen::Isometry3d head_at(double time_s) const;

 private:
  struct Wave {
    double amplitude;
    double rate_rad_per_s;
    double phase_rad;
  };
  double value(std::size_t axis, double time_s) const;

  // yaw, pitch, roll in rad; x, y, z in mm.
  std::array<std::array<Wave, 2>, 6> waves_;
};

}  // namespace zygoma
