#include "src/io/video_clock.h"

#include <cmath>

namespace zygoma {

double VideoClock::next(double stamp_s) {
  const int index = num_pictures_++;
  if (index == 0) {
    first_stamp_s_ = std::isfinite(stamp_s) ? stamp_s : 0.0;
    return 0.0;
  }
  double time_s = stamp_s - first_stamp_s_;
  if (std::isfinite(time_s) && time_s > last_time_s_) {
    has_time_ = true;
    last_step_s_ = time_s - last_time_s_;
  } else {
    // Without any stamp so far, index / rate rather than sums of steps: no drift.
    time_s = has_time_ ? last_time_s_ + last_step_s_ : index / average_frames_per_s_;
    repaired_.push_back(index);
  }
  return last_time_s_ = time_s;
}

}  // namespace zygoma
