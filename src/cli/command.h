// A command of the program (`zygoma NAME ...`): one file in src/cli/commands that defines
//
//   std::unique_ptr<Command> make_NAME_command();
//
// Being there is all the registration it needs: the build lists the folder. A command declares what
// it takes, then runs with what was given; parsing, help, ranges, error lines and exit codes are
// the framework's (src/cli/cli.h), so a command neither catches exceptions nor prints errors.
#pragma once

#include <iosfwd>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/base/stop.h"
#include "src/cli/progress.h"

namespace zygoma {

// A closed interval; the default admits every finite value.
template <typename T>
struct Range {
  T low = std::numeric_limits<T>::lowest();
  T high = std::numeric_limits<T>::max();
};

// Where a command says what it takes. The value a variable holds when it is declared is its
// default and is shown in the help. `names` is "--long" or "-s,--long".
class OptionSink {
 public:
  virtual ~OptionSink() = default;

  // An argument without a dash, shown as `name` ("VIDEO"). Required ones come first.
  virtual void positional(const char* name, std::string& value, const char* help) = 0;
  virtual void optional_positional(const char* name, std::string& value, const char* help) = 0;

  // `kind` is the word shown for the value in the help ("FILE", "FOLDER").
  virtual void text(const char* names, std::string& value, const char* kind, const char* help) = 0;
  // May be given more than once.
  virtual void texts(const char* names,
                     std::vector<std::string>& values,
                     const char* kind,
                     const char* help) = 0;
  // One of the words in `allowed`.
  virtual void choice(const char* names,
                      std::string& value,
                      std::vector<std::string> allowed,
                      const char* help) = 0;
  virtual void integer(const char* names, int& value, Range<int> range, const char* help) = 0;
  virtual void number(const char* names, double& value, Range<double> range, const char* help) = 0;
  // Takes no value: given means true.
  virtual void flag(const char* names, bool& value, const char* help) = 0;
};

// What the world offers to a running command.
struct RunContext {
  std::ostream& out;   // stdout, for results
  Progress& progress;  // on stderr
  StopQuestion stop;   // true once Ctrl-C was pressed
  // Every option of the command with its final value, by long name without dashes, in the order
  // declared: for the session file.
  std::vector<std::pair<std::string, std::string>> options;
};

class Command {
 public:
  virtual ~Command() = default;

  virtual std::string name() const = 0;
  virtual std::string help() const = 0;  // one line, for `zygoma --help`
  // For `zygoma NAME --help`: what it writes and how it goes on; arguments of an example.
  virtual std::string details() const { return {}; }
  virtual std::string example() const { return {}; }
  // Commands are listed by rising rank, those of equal rank by name.
  virtual int rank() const { return 100; }
  virtual void declare(OptionSink& options) = 0;

  // Returns the exit code. Having been stopped is not a failure: write what there is and return 0,
  // the framework turns it into 130. Throws InputError for bad input.
  virtual int run(RunContext& context) = 0;
};

}  // namespace zygoma
