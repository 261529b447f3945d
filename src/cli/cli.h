// The command line of zygoma: one command per file in src/cli/commands.
#pragma once

namespace zygoma {

// Runs the program; returns its exit code. 0: done, 2: bad input, 130: stopped by Ctrl-C.
int run_command_line(int argc, char** argv);

}  // namespace zygoma
