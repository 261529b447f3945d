// Tells the user how far long work has come: on a terminal one line that is rewritten in place,
// elsewhere (a log file) a plain line every two seconds, and at the end of each stage one line with
// its time. Totals come from container claims, which cannot be trusted, hence "about".
#pragma once

#include <chrono>
#include <iosfwd>
#include <string>

namespace zygoma {

class Progress {
 public:
  enum class Style { kSilent, kPlainLines, kOneLine };

  Progress(std::ostream& stream, Style style) : stream_(stream), style_(style) {}
  ~Progress();  // closes a line left open
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // kOneLine if stderr is a terminal that can rewrite a line, else kPlainLines.
  static Style style_of_stderr();

  // A new stage of `about_total` units (frames, as a rule); 0 when nobody knows.
  void begin(std::string stage, int about_total = 0, std::string unit = "frame");
  // `done` units are complete. Cheap: prints at most ten times (plain lines: once in 2) a second.
  void update(int done);
  // The stage is over: says how many units took how long.
  void end();

  // One line of information in between, without disturbing the progress line.
  void note(const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;

  double seconds_since(Clock::time_point then) const;
  void clear_line();

  std::ostream& stream_;
  Style style_;
  std::string stage_;
  std::string unit_;
  int about_total_ = 0;
  int done_ = 0;
  bool line_open_ = false;
  Clock::time_point begun_;
  Clock::time_point printed_;
};

}  // namespace zygoma
