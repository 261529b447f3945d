// The command line of zygoma: one command per file in src/cli/commands (see command.h).
//
// Exit codes: 0 done; 1 the program failed; 2 bad input (unknown option, unreadable file, value out
// of range): one line on stderr that says which and what was expected; 130 stopped by Ctrl-C.
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "src/cli/command.h"

namespace zygoma {

// Runs the program; returns its exit code.
int run_command_line(int argc, char** argv);

// The same for given commands and streams (stdin is never read). `arguments` excludes the
// program's name. `progress` goes to `err` too.
struct CommandLine {
  std::vector<std::unique_ptr<Command>> commands;
  std::ostream& out;
  std::ostream& err;
  Progress::Style progress = Progress::Style::kSilent;
  StopQuestion stop;
};
int run_command_line(CommandLine& program, const std::vector<std::string>& arguments);

}  // namespace zygoma
