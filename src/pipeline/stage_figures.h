// How long a stage took and over how many frames; what session.json and the closing lines quote.
#pragma once

#include <chrono>
#include <ctime>
#include <string>

namespace zygoma {

struct StageFigures {
  std::string name;
  int num_frames = 0;
  double total_ms = 0.0;

  double frame_ms() const { return num_frames > 0 ? total_ms / num_frames : 0.0; }
};

// Processor time of the calling thread: what others do meanwhile does not count.
inline double thread_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

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
