// Time stamps that increase, from container stamps that should: whatever the container says, the
// n-th picture gets a later time than the one before it, and the first one 0.
#pragma once

#include <vector>

namespace zygoma {

class VideoClock {
 public:
  explicit VideoClock(double average_frames_per_s) : average_frames_per_s_(average_frames_per_s) {}

  // The time of the next picture, whose container stamp is given.
  double next(double stamp_s);

  // Pictures whose stamp did not increase: they continue with the last step. All but the first in
  // a stream without time (raw H.264), where the time is index / rate.
  const std::vector<int>& repaired() const { return repaired_; }
  bool has_time() const { return num_pictures_ < 2 || has_time_; }

 private:
  double average_frames_per_s_;
  double first_stamp_s_ = 0.0;
  double last_time_s_ = 0.0;
  double last_step_s_ = 0.0;
  int num_pictures_ = 0;
  bool has_time_ = false;
  std::vector<int> repaired_;
};

}  // namespace zygoma
