// How the project says that something from outside is wrong.
//
// Bad input (a file, an option, a value read from either) throws InputError with a text that names
// the file, the value and what was expected; main() catches it once, prints the one line and exits
// with 2. Misuse by a programmer is an assert(). A numerical outcome (not converged, lost contour)
// is neither: it is data in a report.
#pragma once

#include <stdexcept>
#include <string>

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

}  // namespace zygoma
