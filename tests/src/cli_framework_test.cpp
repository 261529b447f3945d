// The command line's framework: parsing, ranges, help, exit codes and one-line errors, with a
// command of the test's own.
#include <gtest/gtest.h>

#include <new>
#include <sstream>
#include <stdexcept>

#include "src/base/check.h"
#include "src/cli/cli.h"
#include "src/cli/help_text.h"

namespace zygoma {
namespace {

struct Received {
  std::string video;
  std::string output = "out";
  std::string schedule = "mixed";
  int frames = 30;
  double rate = 25.0;
  bool fast = false;
  std::vector<std::string> tags;
  int runs = 0;
  std::vector<std::pair<std::string, std::string>> options;
};

class EchoCommand : public Command {
 public:
  EchoCommand(Received& received, std::function<int(RunContext&)> body)
      : received_(received), body_(std::move(body)) {}

  std::string name() const override { return "echo"; }
  std::string help() const override { return "Says what it was given"; }
  void declare(OptionSink& options) override {
    options.positional("VIDEO", received_.video, "The video to read");
    options.text("-o,--output", received_.output, "FOLDER", "Where to write");
    options.choice("--schedule", received_.schedule, {"mixed", "smile"}, "What happens");
    options.integer("--frames", received_.frames, {1, 600}, "How many frames");
    options.number("--rate", received_.rate, {5.0, 120.0}, "Frames per second");
    options.flag("--fast", received_.fast, "Skip the refinement");
    options.texts("--tag", received_.tags, "WORD", "A word to remember");
  }
  int run(RunContext& context) override {
    ++received_.runs;
    received_.options = context.options;
    return body_ ? body_(context) : 0;
  }

 private:
  Received& received_;
  std::function<int(RunContext&)> body_;
};

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
};

Outcome run(const std::vector<std::string>& arguments,
            Received& received,
            std::function<int(RunContext&)> body = {},
            StopQuestion stop = {}) {
  std::ostringstream out;
  std::ostringstream err;
  CommandLine program{{}, out, err, Progress::Style::kSilent, std::move(stop)};
  program.commands.push_back(std::make_unique<EchoCommand>(received, std::move(body)));
  Outcome outcome;
  outcome.code = run_command_line(program, arguments);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

// Bad input: exit code 2, nothing on stdout, exactly one line on stderr that has all the words.
void expect_refused(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& words) {
  Received received;
  const Outcome outcome = run(arguments, received);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(received.runs, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;
  EXPECT_TRUE(outcome.err.starts_with("zygoma: ")) << outcome.err;
  for (const std::string& word : words) {
    EXPECT_NE(outcome.err.find(word), std::string::npos)
        << "no '" << word << "' in " << outcome.err;
  }
}

TEST(CommandLineTest, FillsEveryKindOfOption) {
  Received received;
  const Outcome outcome = run({"echo",
                               "clip.mp4",
                               "-o",
                               "there",
                               "--schedule=smile",
                               "--frames",
                               "7",
                               "--rate",
                               "59.94",
                               "--fast"},
                              received);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(received.video, "clip.mp4");
  EXPECT_EQ(received.output, "there");
  EXPECT_EQ(received.schedule, "smile");
  EXPECT_EQ(received.frames, 7);
  EXPECT_EQ(received.rate, 59.94);
  EXPECT_TRUE(received.fast);
  const std::vector<std::pair<std::string, std::string>> expected{{"VIDEO", "clip.mp4"},
                                                                  {"output", "there"},
                                                                  {"schedule", "smile"},
                                                                  {"frames", "7"},
                                                                  {"rate", "59.94"},
                                                                  {"fast", "true"},
                                                                  {"tag", ""}};
  EXPECT_EQ(received.options, expected);
}

TEST(CommandLineTest, SomeOptionsMayBeGivenMoreThanOnce) {
  Received received;
  EXPECT_EQ(run({"echo", "--tag", "a", "clip.mp4", "--tag", "b:c=1,d=2"}, received).code, 0);
  EXPECT_EQ(received.tags, (std::vector<std::string>{"a", "b:c=1,d=2"}));
  EXPECT_EQ(received.video, "clip.mp4");
  EXPECT_EQ(received.options.back(), (std::pair<std::string, std::string>{"tag", "a b:c=1,d=2"}));
}

TEST(CommandLineTest, KeepsDefaultsAndAcceptsOptionsBeforeThePositional) {
  Received received;
  EXPECT_EQ(run({"echo", "--fast", "clip.mp4"}, received).code, 0);
  EXPECT_EQ(received.video, "clip.mp4");
  EXPECT_EQ(received.output, "out");
  EXPECT_EQ(received.frames, 30);
}

TEST(CommandLineTest, HelpNamesOptionsRangesAndDefaults) {
  Received received;
  const Outcome all = run({"--help"}, received);
  EXPECT_EQ(all.code, 0);
  EXPECT_NE(all.out.find("echo  Says what it was given"), std::string::npos) << all.out;

  const Outcome one = run({"echo", "--help"}, received);
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(received.runs, 0);
  for (const char* words : {"VIDEO",
                            "-o,--output FOLDER",
                            "Where to write (default out)",
                            "mixed | smile (default mixed)",
                            "How many frames (in [1, 600], default 30)",
                            "Frames per second (in [5, 120], default 25)",
                            "Skip the refinement"}) {
    EXPECT_NE(one.out.find(words), std::string::npos) << "no '" << words << "' in\n" << one.out;
  }
}

TEST(CommandLineTest, HelpIsWrappedBetweenWords) {
  EXPECT_EQ(wrapped("a bc def", 4, 2), "a bc\n  def");
  EXPECT_EQ(wrapped("overlong x", 4, 1), "overlong\n x");
  const std::string table = two_columns(
      {{"-a", "short"}, {"--long-name", std::string(30, 'x') + " " + std::string(40, 'y')}});
  EXPECT_EQ(table,
            "  -a           short\n  --long-name  " + std::string(30, 'x') + "\n" +
                std::string(15, ' ') + std::string(40, 'y') + "\n");
}

TEST(CommandLineTest, SaysItsVersion) {
  Received received;
  EXPECT_EQ(run({"--version"}, received).out.substr(0, 7), "zygoma ");
}

TEST(CommandLineTest, RefusesBadArgumentsInOneLine) {
  expect_refused({}, {"no command", "echo"});
  expect_refused({"ehco"}, {"unknown command 'ehco'", "echo"});
  expect_refused({"--frobnicate"}, {"unknown option '--frobnicate'"});
  expect_refused({"echo"}, {"VIDEO", "required", "zygoma echo --help"});
  expect_refused({"echo", "a.mp4", "b.mp4"}, {"b.mp4"});
  expect_refused({"echo", "a.mp4", "--frobnicate"}, {"--frobnicate"});
  expect_refused({"echo", "a.mp4", "--frames"}, {"--frames"});
  expect_refused({"echo", "a.mp4", "--tag"}, {"--tag"});
  expect_refused({"echo", "a.mp4", "--frames", "0"}, {"--frames", "0", "[1, 600]"});
  expect_refused({"echo", "a.mp4", "--frames", "-1"}, {"--frames", "-1", "[1, 600]"});
  expect_refused({"echo", "a.mp4", "--frames", "3.5"}, {"--frames", "'3.5'", "whole number"});
  expect_refused({"echo", "a.mp4", "--frames", "99999999999"}, {"--frames", "99999999999"});
  expect_refused({"echo", "a.mp4", "--rate", "fast"}, {"--rate", "'fast'", "number"});
  expect_refused({"echo", "a.mp4", "--rate", "nan"}, {"--rate", "'nan'"});
  expect_refused({"echo", "a.mp4", "--rate", "25,0"}, {"--rate", "'25,0'"});
  expect_refused({"echo", "a.mp4", "--rate", "1000"}, {"--rate", "1000", "[5, 120]"});
  expect_refused({"echo", "a.mp4", "--schedule", "dance"},
                 {"--schedule", "'dance'", "mixed | smile"});
}

TEST(CommandLineTest, TurnsExceptionsIntoOneLineAndACode) {
  const auto outcome_of = [](std::function<int(RunContext&)> body) {
    Received received;
    return run({"echo", "a.mp4"}, received, std::move(body));
  };
  const Outcome input =
      outcome_of([](RunContext&) -> int { throw InputError("a.mp4: no such file"); });
  EXPECT_EQ(input.code, 2);
  EXPECT_EQ(input.err, "zygoma: a.mp4: no such file\n");

  const Outcome library =
      outcome_of([](RunContext&) -> int { throw std::runtime_error("first\nsecond\n"); });
  EXPECT_EQ(library.code, 1);
  EXPECT_EQ(library.err, "zygoma: first second\n");

  const Outcome memory = outcome_of([](RunContext&) -> int { throw std::bad_alloc(); });
  EXPECT_EQ(memory.code, 1);
  EXPECT_EQ(memory.err, "zygoma: not enough memory\n");
}

TEST(CommandLineTest, ReportsStopOnlyWhenTheWorkHeardOfIt) {
  Received received;
  const StopQuestion always = [] { return true; };
  EXPECT_EQ(run(
                {"echo", "a"}, received, [](RunContext& c) { return c.stop() ? 0 : 5; }, always)
                .code,
            130);
  EXPECT_EQ(run(
                {"echo", "a"}, received, [](RunContext&) { return 0; }, always)
                .code,
            0);
  EXPECT_EQ(run({"echo", "a"}, received, [](RunContext& c) { return c.stop() ? 5 : 0; }).code, 0);
}

TEST(ProgressTest, PlainStyleEndsAStageWithOneLine) {
  std::ostringstream log;
  {
    Progress progress(log, Progress::Style::kPlainLines);
    progress.begin("track", 100);
    for (int i = 1; i <= 40; ++i) progress.update(i);
    progress.end();
  }
  EXPECT_EQ(log.str().substr(0, 21), "track: 40 frames in 0") << log.str();
  EXPECT_EQ(log.str().find('\r'), std::string::npos);
  EXPECT_EQ(log.str().find('\n'), log.str().size() - 1);
}

}  // namespace
}  // namespace zygoma
