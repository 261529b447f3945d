// A motion of the face as a few keyed poses, and what the muscles do in between.
//
// A key is a whole pose: a muscle it does not name is slack, and the jaw is closed unless it says
// otherwise. Between keys every value follows a cubic Hermite piece whose slopes are those of
// Fritsch and Butland (1984),
//
//   d_k = 3 (h_- + h_+) / ((2 h_+ + h_-) / s_- + (h_+ + 2 h_-) / s_+)  if s_- s_+ > 0,  else 0
//
// with h the lengths and s the secants of the two intervals at a key; 0 at both ends. The curve is
// C1, rises only where the keys rise, and so stays between them: in [0, 1], without clamping.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "face/contractions.h"

namespace zygoma {

struct MotionKey {
  double time_s = 0.0;
  double jaw = 0.0;                           // [0, 1] of Jaw::full_rad
  std::map<std::string, double> contraction;  // [0, 1] by muscle
};

struct Motion {
  double frames_per_s = 30.0;  // [1, 1000]
  double duration_s = 0.0;     // the last pose is held until then; 0 = as long as the keys
  std::vector<MotionKey> keys;

  static constexpr int kMostFrames = 100000;
  // Throws InputError naming the value outside its range, or the key that is out of order.
  void check() const;
};

// The value at time `at` of the monotone curve through (time[k], value[k]); constant beyond the
// ends. Times rise.
double monotone_curve(const std::vector<double>& time, const std::vector<double>& value, double at);

// Those of `muscles` that the motion uses, with their other side; all of them if it uses none.
std::vector<std::string> muscles_used(const Motion& motion,
                                      const std::vector<std::string>& muscles);

// Every frame from 0 to the duration, for muscles in the order given. Throws InputError naming a
// muscle of the motion that is not among them.
ContractionTrack sample_motion(const Motion& motion, const std::vector<std::string>& muscles);

}  // namespace zygoma
