// What the benchmarks share: CPU time of the process (other programs run beside them), medians, and
// tables that go to the screen and to a CSV file with one line on how they came about.
#pragma once

#include <sys/resource.h>
#include <sys/time.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace zygoma::bench {

inline double cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e3 * static_cast<double>(usage.ru_utime.tv_sec) +
         1e-3 * static_cast<double>(usage.ru_utime.tv_usec);
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Milliseconds of one call, from enough calls to be measured.
template <typename Work>
double ms_per_call(Work work, double at_least_ms = 4.0) {
  for (int calls = 1;; calls *= 2) {
    const double begin = cpu_ms();
    for (int k = 0; k < calls; ++k) work();
    const double ms = cpu_ms() - begin;
    if (ms >= at_least_ms) return ms / calls;
  }
}

class Table {
 public:
  // No file if the path is empty. `about`: what was run, the commit, the machine.
  Table(const std::string& path, const std::string& about, const std::string& columns) {
    if (!path.empty()) file_.open(path);
    std::printf("# %s\n%s\n", about.c_str(), columns.c_str());
    if (file_.is_open()) file_ << "# " << about << '\n' << columns << '\n';
  }
  void line(const std::string& text) {
    std::printf("%s\n", text.c_str());
    std::fflush(stdout);
    if (file_.is_open()) file_ << text << std::endl;
  }

 private:
  std::ofstream file_;
};

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace zygoma::bench
