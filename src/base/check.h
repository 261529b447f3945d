// How the project says that something from outside is wrong.
//
// Bad input (a file, an option, a value read from either) throws InputError with a text that names
// the file, the value and what was expected; main() catches it once, prints the one line and exits
// with 2. Misuse by a programmer is an assert(). A numerical outcome (not converged, lost contour)
// is neither: it is data in a report.
#pragma once

#include <charconv>
#include <stdexcept>
#include <string>
#include <string_view>

namespace zygoma {

class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws InputError(message) unless the condition holds.
inline void require(bool condition, const char* message) {
  if (!condition) throw InputError(message);
}
inline void require(bool condition, const std::string& message) {
  if (!condition) throw InputError(message);
}

// The shortest text that reads back as the same value, in every locale.
inline std::string shortest_text(double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, result.ptr);
}

// `value` made fit for a one-line message: quoted, cut to a length that can be read.
inline std::string quote_value(std::string_view value) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : value.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (value.size() > kLongest ? "...'" : "'");
}

// Throws InputError("NAME is VALUE, expected LOW to HIGH") unless it is; NaN never is.
inline void require_range(const std::string& name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw InputError(name + " is " + shortest_text(value) + ", expected " + shortest_text(low) +
                   " to " + shortest_text(high));
}

}  // namespace zygoma
