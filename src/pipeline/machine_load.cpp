#include "src/pipeline/machine_load.h"

#include <algorithm>
#include <ctime>
#include <fstream>
#include <string>

namespace zygoma {
namespace {

constexpr double kTick_s = 0.01;  // of /proc/stat, on every Linux there is

struct Times {
  double busy_s = 0.0;
  double total_s = 0.0;
};

// Of all processors together, since the machine started.
Times machine_times() {
  std::ifstream file("/proc/stat");
  std::string word;
  file >> word;
  if (word != "cpu") return {};
  // user nice system idle iowait irq softirq steal
  constexpr int kNumStates = 8;
  constexpr int kIdle = 3;
  constexpr int kWaitsForDisk = 4;
  Times times;
  double ticks = 0.0;
  for (int state = 0; state < kNumStates && file >> ticks; ++state) {
    times.total_s += kTick_s * ticks;
    if (state != kIdle && state != kWaitsForDisk) times.busy_s += kTick_s * ticks;
  }
  return times;
}

double own_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

LoadMeter::LoadMeter() {
  const Times now = machine_times();
  machine_busy_s_ = now.busy_s;
  machine_total_s_ = now.total_s;
  own_s_ = own_s();
}

double LoadMeter::share_of_others() const {
  const Times now = machine_times();
  const double total = now.total_s - machine_total_s_;
  if (total <= 0.0) return 0.0;
  const double others = now.busy_s - machine_busy_s_ - (own_s() - own_s_);
  return std::clamp(others / total, 0.0, 1.0);
}

}  // namespace zygoma
