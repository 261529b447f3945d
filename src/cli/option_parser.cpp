#include "src/cli/option_parser.h"

#include <CLI/CLI.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>

#include "src/base/names.h"
#include "src/cli/help_text.h"

namespace zygoma {
namespace {

// The shortest text that reads back as the same value, with a point in every locale.
template <typename T>
std::string shortest_text(T value) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, result.ptr);
}

template <typename T>
bool parse_whole(const std::string& text, T& value) {
  const char* first = text.data();
  const char* last = first + text.size();
  if (first != last && *first == '+') ++first;
  const auto result = std::from_chars(first, last, value);
  return result.ec == std::errc() && result.ptr == last && first != last;
}

template <typename T>
bool bounded(Range<T> range) {
  return range.low != Range<T>{}.low || range.high != Range<T>{}.high;
}

template <typename T>
std::string range_text(Range<T> range) {
  if (range.low == Range<T>{}.low) return "at most " + shortest_text(range.high);
  if (range.high == Range<T>{}.high) return "at least " + shortest_text(range.low);
  return "in [" + shortest_text(range.low) + ", " + shortest_text(range.high) + "]";
}

// "-o,--output" -> "--output"
std::string long_name(const std::string& names) {
  const auto comma = names.rfind(',');
  return comma == std::string::npos ? names : names.substr(comma + 1);
}

std::string without_dashes(const std::string& name) {
  const auto first = name.find_first_not_of('-');
  return first == std::string::npos ? name : name.substr(first);
}

class Cli11Sink : public OptionSink {
 public:
  explicit Cli11Sink(CLI::App& app) : app_(app) {}

  void positional(const char* name, std::string& value, const char* help) override {
    add(name, value, name, help, {})->required();
    usage_ += std::string(" ") + name;
  }

  void optional_positional(const char* name, std::string& value, const char* help) override {
    add(name, value, name, help, {});
    usage_ += std::string(" [") + name + "]";
  }

  void text(const char* names, std::string& value, const char* kind, const char* help) override {
    add(names, value, kind, help, {});
  }

  void texts(const char* names,
             std::vector<std::string>& values,
             const char* kind,
             const char* help) override {
    const CLI::callback_t given = [&values](const CLI::results_t& results) {
      values = results;
      return true;
    };
    options_.push_back({std::string(names) + " " + kind, help});
    app_.add_option(names, given, help)->take_all()->allow_extra_args(false);
    values_.push_back({long_name(names), [&values] { return joined_names(values, " "); }});
  }

  void choice(const char* names,
              std::string& value,
              std::vector<std::string> allowed,
              const char* help) override {
    const std::string words = joined_names(allowed, " | ");
    const std::string name = long_name(names);
    add(names, value, "WORD", std::string(help) + ": " + words, [=](const std::string& given) {
      require(find_name(allowed, given) >= 0, name + ": '" + given + "' is not one of " + words);
    });
  }

  void integer(const char* names, int& value, Range<int> range, const char* help) override {
    add_number(names, value, range, "INT", "a whole number", help);
  }

  void number(const char* names, double& value, Range<double> range, const char* help) override {
    add_number(names, value, range, "NUMBER", "a number", help);
  }

  void flag(const char* names, bool& value, const char* help) override {
    const CLI::callback_t given = [&value](const CLI::results_t&) { return value = true; };
    app_.add_option(names, given, help)->type_size(0)->expected(0);
    options_.push_back({names, help});
    values_.push_back({long_name(names), [&value] { return value ? "true" : "false"; }});
  }

  std::vector<std::pair<std::string, std::string>> values() const {
    std::vector<std::pair<std::string, std::string>> result;
    for (const auto& [name, text] : values_) result.emplace_back(without_dashes(name), text());
    return result;
  }

  std::string help_text(const Command& command) const {
    const std::string program = "zygoma " + command.name();
    std::string text = "Usage: " + program + usage_ + " [OPTIONS]\n\n";
    std::string sentence = command.help() + ".";
    sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
    for (const std::string& paragraph : {sentence, command.details()}) {
      if (!paragraph.empty()) text += wrapped(paragraph, 80, 0) + "\n\n";
    }
    if (!arguments_.empty()) text += two_columns(arguments_) + "\n";
    std::vector<HelpEntry> options = options_;
    options.push_back({"-h,--help", "show this text"});
    text += "Options:\n" + two_columns(options);
    if (!command.example().empty()) {
      text += "\nExample:\n  " + program + " " + command.example() + "\n";
    }
    return text;
  }

 private:
  using Check = std::function<void(const std::string&)>;

  CLI::Option* add(const std::string& names,
                   std::string& value,
                   const std::string& kind,
                   const std::string& help,
                   const Check& check) {
    const std::string shown = value.empty() ? help : help + " (default " + value + ")";
    const CLI::callback_t given = [&value, check](const CLI::results_t& results) {
      if (check) check(results.back());
      value = results.back();
      return true;
    };
    values_.push_back({long_name(names), [&value] { return value; }});
    const bool has_dash = names.starts_with("-");
    (has_dash ? options_ : arguments_).push_back({has_dash ? names + " " + kind : names, shown});
    return app_.add_option(names, given, shown);
  }

  template <typename T>
  void add_number(const std::string& names,
                  T& value,
                  Range<T> range,
                  const std::string& kind,
                  const char* expected,
                  const std::string& help) {
    std::string shown = help + " (";
    if (bounded(range)) shown += range_text(range) + ", ";
    shown += "default " + shortest_text(value) + ")";
    const std::string name = long_name(names);
    const CLI::callback_t given = [&value, range, name, expected](const CLI::results_t& results) {
      const std::string& text = results.back();
      T parsed{};
      const bool is_number =
          parse_whole(text, parsed) && std::isfinite(static_cast<double>(parsed));
      require(is_number, name + ": '" + text + "' is not " + expected);
      require(parsed >= range.low && parsed <= range.high,
              name + ": " + text + " is out of range, it must be " + range_text(range));
      value = parsed;
      return true;
    };
    options_.push_back({std::string(names) + " " + kind, shown});
    app_.add_option(names, given, shown);
    values_.push_back({name, [&value] { return shortest_text(value); }});
  }

  CLI::App& app_;
  std::string usage_;
  std::vector<HelpEntry> arguments_;
  std::vector<HelpEntry> options_;
  std::vector<std::pair<std::string, std::function<std::string()>>> values_;
};

}  // namespace

ParsedOptions parse_options(Command& command, const std::vector<std::string>& arguments) {
  CLI::App app;
  app.set_help_flag("-h,--help", "");
  Cli11Sink sink(app);
  command.declare(sink);

  const std::string advice = " (zygoma " + command.name() + " --help lists what it takes)";
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    return {sink.help_text(command), {}};
  } catch (const CLI::ParseError& error) {
    throw InputError(error.what() + advice);
  }
  return {"", sink.values()};
}

}  // namespace zygoma
