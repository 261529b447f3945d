// The built program as a child process: what it is given, what it says, how it ends.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/src/scratch_folder.h"

namespace zygoma {

struct Outcome {
  int code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

inline int num_lines(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

// Without the lines that say how far the work is, which only a slow machine gets to see.
inline std::string without_progress(const std::string& err) {
  std::istringstream lines(err);
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    if (line.find(": frame ") == std::string::npos) kept += line + '\n';
  }
  return kept;
}

class RunningProgram {
 public:
  RunningProgram(const ScratchFolder& folder, const std::vector<std::string>& arguments)
      : out_(folder / "stdout"), err_(folder / "stderr") {
    std::vector<std::string> words{ZYGOMA_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_.c_str(), kWrite, 0600);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_.c_str(), kWrite, 0600);
    const int failure = posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    EXPECT_EQ(failure, 0) << argv[0] << " cannot be started";
    if (failure != 0) pid_ = -1;
  }
  ~RunningProgram() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // False when the program ends before the file or folder is there.
  bool wait_for(const std::string& path) {
    using namespace std::chrono_literals;
    siginfo_t info{};
    while (pid_ > 0 && !std::filesystem::exists(path)) {
      waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT);
      if (info.si_pid == pid_) return std::filesystem::exists(path);
      std::this_thread::sleep_for(2ms);
    }
    return pid_ > 0;
  }

  void press_ctrl_c() const {
    if (pid_ > 0) kill(pid_, SIGINT);
  }

  Outcome finish() {
    int status = 0;
    if (pid_ <= 0 || waitpid(pid_, &status, 0) != pid_) return {};
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, bytes_of(out_), bytes_of(err_)};
  }

 private:
  std::string out_;
  std::string err_;
  pid_t pid_ = -1;
};

inline Outcome run_program(const ScratchFolder& folder, const std::vector<std::string>& arguments) {
  return RunningProgram(folder, arguments).finish();
}

}  // namespace zygoma
