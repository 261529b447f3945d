#include "src/cli/progress.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ostream>
#include <utility>

namespace zygoma {
namespace {

constexpr double kRewriteEvery_s = 0.1;
constexpr double kPlainLineEvery_s = 2.0;

std::string one_decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

// "48 s", "3 min 20 s", "1 h 05 min"
std::string duration_text(double seconds) {
  const long total = static_cast<long>(seconds + 0.5);
  char text[48];
  if (total < 60) {
    std::snprintf(text, sizeof text, "%ld s", total);
  } else if (total < 3600) {
    std::snprintf(text, sizeof text, "%ld min %02ld s", total / 60, total % 60);
  } else {
    std::snprintf(text, sizeof text, "%ld h %02ld min", total / 3600, total / 60 % 60);
  }
  return text;
}

}  // namespace

Progress::~Progress() { clear_line(); }

Progress::Style Progress::style_of_stderr() {
  const char* terminal = std::getenv("TERM");
  const bool can_rewrite =
      isatty(STDERR_FILENO) == 1 && terminal != nullptr && std::strcmp(terminal, "dumb") != 0;
  return can_rewrite ? Style::kOneLine : Style::kPlainLines;
}

void Progress::begin(std::string stage, int about_total, std::string unit) {
  clear_line();
  stage_ = std::move(stage);
  unit_ = std::move(unit);
  about_total_ = about_total;
  done_ = 0;
  begun_ = printed_ = Clock::now();
}

void Progress::update(int done) {
  done_ = done;
  if (style_ == Style::kSilent) return;
  const bool rewrite = style_ == Style::kOneLine;
  if (seconds_since(printed_) < (rewrite ? kRewriteEvery_s : kPlainLineEvery_s)) return;
  printed_ = Clock::now();

  std::string line = stage_ + ": " + unit_ + " " + std::to_string(done);
  // A claim that has been overtaken was wrong; better no total than a wrong one.
  const bool total_is_credible = about_total_ > 0 && done <= about_total_;
  if (total_is_credible) line += " of about " + std::to_string(about_total_);
  const double units_per_s = done / seconds_since(begun_);
  line += ", " + one_decimal(units_per_s) + " " + unit_ + "s/s";
  if (total_is_credible && units_per_s > 0) {
    line += ", about " + duration_text((about_total_ - done) / units_per_s) + " left";
  }
  if (rewrite) {
    stream_ << '\r' << line << "\033[K" << std::flush;
    line_open_ = true;
  } else {
    stream_ << line << '\n' << std::flush;
  }
}

void Progress::end() {
  clear_line();
  if (style_ == Style::kSilent || stage_.empty()) return;
  const double seconds = seconds_since(begun_);
  stream_ << stage_ << ": " << done_ << ' ' << unit_ << (done_ == 1 ? "" : "s") << " in "
          << one_decimal(seconds) << " s";
  if (done_ > 0 && seconds > 0.05) {
    stream_ << " (" << one_decimal(done_ / seconds) << ' ' << unit_ << "s/s)";
  }
  stream_ << '\n' << std::flush;
  stage_.clear();
}

void Progress::note(const std::string& line) {
  if (style_ == Style::kSilent) return;
  clear_line();
  stream_ << line << '\n' << std::flush;
}

double Progress::seconds_since(Clock::time_point then) const {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

void Progress::clear_line() {
  if (!line_open_) return;
  stream_ << "\r\033[K" << std::flush;
  line_open_ = false;
}

}  // namespace zygoma
