// What a performer does over time: pulses of muscles that rise, hold and fall with the smoothness
// of human movement (minimum jerk: 10 x^3 - 15 x^4 + 6 x^5).
//
// A performance is a chain of cycles of a few seconds. Every cycle starts and ends at rest, and its
// levels, sides and times vary with the seed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace zygoma {

// One muscle's share in an expression. An empty muscle is the jaw.
struct Pulse {
  std::string muscle;
  double level = 0.0;
  double start_s = 0.0;
  double rise_s = 0.0;
  double hold_s = 0.0;
  double fall_s = 0.0;

  double value_at(double time_s) const;
};

struct Schedule {
  std::vector<Pulse> pulses;

  // Sum of the muscle's pulses, in [0, 1]; muscle "" for the jaw.
  double value_at(const std::string& muscle, double time_s) const;
};

// Names make_schedule() knows.
const std::vector<std::string>& schedule_names();

Schedule make_schedule(const std::string& name, double duration_s, std::uint32_t seed);

}  // namespace zygoma
