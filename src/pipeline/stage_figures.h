// How long a stage took and over how many frames; what session.json and the closing lines quote.
#pragma once

#include <chrono>
#include <string>

namespace zygoma {

struct StageFigures {
  std::string name;
  int num_frames = 0;
  double total_ms = 0.0;

  double frame_ms() const { return num_frames > 0 ? total_ms / num_frames : 0.0; }
};

class Stopwatch {
 public:
  double elapsed_ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace zygoma
