// Stops the program at the first operation that makes an infinity or a NaN out of numbers, so that
// one that is lost again later is found as well. Glibc only; elsewhere it does nothing.
#pragma once

#include <gtest/gtest.h>

#include <cfenv>

namespace zygoma::hard {

class FloatingPointTraps {
 public:
  FloatingPointTraps() {
#ifdef __GLIBC__
    std::feclearexcept(FE_ALL_EXCEPT);
    before_ = feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
#endif
  }
  ~FloatingPointTraps() {
#ifdef __GLIBC__
    fedisableexcept(FE_ALL_EXCEPT);
    std::feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(before_);
#endif
  }
  FloatingPointTraps(const FloatingPointTraps&) = delete;
  FloatingPointTraps& operator=(const FloatingPointTraps&) = delete;

 private:
  [[maybe_unused]] int before_ = 0;
};

// Base of the test suites whose cases go through a solver.
class Trapped : public testing::Test {
 private:
  FloatingPointTraps traps_;
};

}  // namespace zygoma::hard
