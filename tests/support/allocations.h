// Counts the allocations of this program: for showing that a hot loop makes none.
//
// Include from one file of a test program only: it replaces malloc, which both operator new and
// Eigen call. Where a sanitizer already has its own, nothing is counted (can_count_allocations).
#pragma once

#include <cstddef>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

extern "C" void* __libc_malloc(std::size_t size);

namespace zygoma::test_support {

inline constexpr bool can_count_allocations = true;
inline thread_local long num_allocations = 0;

}  // namespace zygoma::test_support

extern "C" void* malloc(std::size_t size) {
  ++zygoma::test_support::num_allocations;
  return __libc_malloc(size);
}

#else

namespace zygoma::test_support {

inline constexpr bool can_count_allocations = false;
inline long num_allocations = 0;

}  // namespace zygoma::test_support

#endif
