// Fills a command's variables from arguments. The parsing library behind it is slow to compile and
// therefore confined to option_parser.cpp.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "src/cli/command.h"

namespace zygoma {

struct ParsedOptions {
  std::string help_text;  // not empty: --help was asked for, nothing else was parsed
  std::vector<std::pair<std::string, std::string>> values;  // as in RunContext::options
};

// Throws InputError with one line: the option, the value, what was expected.
ParsedOptions parse_options(Command& command, const std::vector<std::string>& arguments);

}  // namespace zygoma
