// Counts the instructions that a piece of work executes, exactly, on any machine: a child process
// does the work and is stepped through it one by one.
#pragma once

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <optional>

namespace zygoma::test_support {

namespace internal {

inline std::optional<long> steps_of(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(1);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFSTOPPED(status)) return std::nullopt;  // not allowed here
  long steps = 0;
  while (ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) == 0) {
    waitpid(child, &status, 0);
    if (WIFEXITED(status) || WIFSIGNALED(status)) break;
    ++steps;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return steps;
}

}  // namespace internal

// Of the work alone; nothing where processes may not be traced.
inline std::optional<long> count_instructions(const std::function<void()>& work) {
  const std::optional<long> around = internal::steps_of([] {});
  const std::optional<long> with = internal::steps_of(work);
  if (!around || !with) return std::nullopt;
  return *with - *around;
}

}  // namespace zygoma::test_support
