#include "src/cli/cli.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <exception>
#include <iostream>
#include <new>

#include "src/base/check.h"
#include "src/cli/help_text.h"
#include "src/cli/option_parser.h"
#include "src/cli/stop_signal.h"
#include "src/io/session_file.h"

namespace zygoma {

#define ZYGOMA_PLUGIN(function) std::unique_ptr<Command> function();
#include "generated/cli_list.inc"
#undef ZYGOMA_PLUGIN

namespace {

constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitBadInput = 2;
constexpr int kExitStopped = 130;

std::vector<std::unique_ptr<Command>> all_commands() {
  std::vector<std::unique_ptr<Command>> commands;
#define ZYGOMA_PLUGIN(function) commands.push_back(function());
#include "generated/cli_list.inc"
#undef ZYGOMA_PLUGIN
  std::stable_sort(commands.begin(), commands.end(), [](const auto& a, const auto& b) {
    return a->rank() < b->rank();
  });
  return commands;
}

// Messages of libraries may span lines; ours never do.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = ' ';
  }
  const auto last = text.find_last_not_of(' ');
  text.resize(last == std::string::npos ? 0 : last + 1);
  return text;
}

std::string command_names(const CommandLine& program) {
  std::string names;
  for (const auto& command : program.commands) {
    names += (names.empty() ? "" : ", ") + command->name();
  }
  return names;
}

void print_help(const CommandLine& program) {
  std::vector<HelpEntry> commands;
  for (const auto& command : program.commands) {
    commands.push_back({command->name(), command->help()});
  }
  program.out << "Zygoma reads the muscles of a face from plain video and moves a physical face\n"
                 "with them.\n\n"
                 "Usage: zygoma COMMAND [OPTIONS]\n\n"
                 "Commands:\n"
              << two_columns(commands) << '\n';
  if (!program.commands.empty() && !program.commands.front()->example().empty()) {
    program.out << "To begin with:\n  zygoma " << program.commands.front()->name() << ' '
                << program.commands.front()->example() << "\n\n";
  }
  program.out << "zygoma COMMAND --help  the options of a command and what it writes\n"
                 "zygoma --version       which version this is\n\n"
                 "Ctrl-C stops between two frames and keeps what is done. Exit codes: 0 done,\n"
                 "1 failed, 2 input that cannot be used, 130 stopped.\n";
}

int run_command(CommandLine& program, Command& command, const std::vector<std::string>& arguments) {
  const ParsedOptions parsed = parse_options(command, arguments);
  if (!parsed.help_text.empty()) {
    program.out << parsed.help_text;
    return kExitDone;
  }
  // Only a stop that the work heard of counts: one that comes after the last question changes
  // nothing about the result.
  std::atomic<bool> stopped{false};
  Progress progress(program.err, program.progress);
  RunContext context{program.out, progress, {}, parsed.values};
  context.stop = [&] {
    if (program.stop && program.stop()) stopped = true;
    return stopped.load();
  };
  const int code = command.run(context);
  return code == kExitDone && stopped ? kExitStopped : code;
}

int dispatch(CommandLine& program, const std::vector<std::string>& arguments) {
  require(!arguments.empty(),
          "no command given; one of " + command_names(program) + " (zygoma --help tells more)");
  const std::string& first = arguments.front();
  if (first == "--help" || first == "-h") {
    print_help(program);
    return kExitDone;
  }
  if (first == "--version") {
    program.out << "zygoma " << kVersion << '\n';
    return kExitDone;
  }
  for (const auto& command : program.commands) {
    if (command->name() == first) {
      return run_command(program, *command, {arguments.begin() + 1, arguments.end()});
    }
  }
  const char* what = first.starts_with("-") ? "unknown option '" : "unknown command '";
  throw InputError(what + first + "'; the commands are " + command_names(program) +
                   " (zygoma --help tells more)");
}

int report(const CommandLine& program, int code, const std::string& message) {
  program.err << "zygoma: " << one_line(message) << '\n' << std::flush;
  return code;
}

}  // namespace

int run_command_line(CommandLine& program, const std::vector<std::string>& arguments) {
  try {
    const int code = dispatch(program, arguments);
    program.out.flush();
    require(program.out.good(), "standard output cannot be written");
    return code;
  } catch (const InputError& error) {
    return report(program, kExitBadInput, error.what());
  } catch (const std::bad_alloc&) {
    return report(program, kExitFailed, "not enough memory");
  } catch (const std::exception& error) {
    return report(program, kExitFailed, error.what());
  }
}

int run_command_line(int argc, char** argv) {
  install_stop_signals();
  CommandLine program{
      all_commands(), std::cout, std::cerr, Progress::style_of_stderr(), stop_was_requested};
  return run_command_line(program, std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
}

}  // namespace zygoma
