// The program itself, given what it cannot use: exit code 2, one line on stderr that names what is
// wrong, nothing on stdout.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
};

std::string in_quotes(const std::string& word) {
  std::string text(1, '\'');
  return text.append(word).append(1, '\'');
}

Outcome run_program(const ScratchFolder& folder, const std::vector<std::string>& arguments) {
  std::string command = in_quotes(ZYGOMA_PROGRAM);
  for (const std::string& argument : arguments) command += " " + in_quotes(argument);
  command +=
      " >" + in_quotes(folder / "stdout") + " 2>" + in_quotes(folder / "stderr") + " </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          bytes_of(folder / "stdout"),
          bytes_of(folder / "stderr")};
}

class BadInputTest : public testing::Test {
 protected:
  void expect_refused(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& words) const {
    const Outcome outcome = run_program(folder_, arguments);
    std::string shown;
    for (const std::string& argument : arguments) shown += argument + " ";
    SCOPED_TRACE(shown);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("zygoma: ")) << outcome.err;
    for (const std::string& word : words) {
      EXPECT_NE(outcome.err.find(word), std::string::npos)
          << "no '" << word << "' in: " << outcome.err;
    }
  }

  // A command that reads FILE and would write into a folder that is fine.
  std::vector<std::string> on(const std::string& command, const std::string& file) const {
    return {command, file, "-o", folder_ / "out"};
  }

  ScratchFolder folder_;
};

TEST_F(BadInputTest, MissingFile) {
  const std::string missing = folder_ / "missing.mp4";
  for (const char* command : {"run", "track"}) {
    expect_refused(on(command, missing), {missing, "no such file", "expected a video"});
  }
  const std::string missing_table = folder_ / "missing.csv";
  for (const char* command : {"retarget", "animate"}) {
    expect_refused(on(command, missing_table), {missing_table, "No such file"});
  }
}

TEST_F(BadInputTest, WrongKindOfFile) {
  const std::string text = folder_.write("text.mp4", "This is no video,\nonly its name is.\n");
  const std::string empty = folder_.write("empty.mp4", "");
  for (const char* command : {"run", "track"}) {
    expect_refused(on(command, text), {text, "cannot be read as a video"});
    expect_refused(on(command, empty), {empty, "is empty"});
    expect_refused(on(command, folder_ / ""), {"is a folder"});
  }
  for (const char* command : {"retarget", "animate"}) {
    expect_refused(on(command, text), {text + ":1:", "missing column"});
    expect_refused(on(command, empty), {empty, "is empty"});
  }
}

TEST_F(BadInputTest, OutputThatCannotBeWritten) {
  const std::string video = folder_.write("clip.mp4", "never read");
  const std::string file = folder_.write("file", "in the way");
  for (const char* command : {"run", "track"}) {
    expect_refused({command, video, "-o", file}, {file});
    expect_refused({command, video, "-o", file + "/below"}, {file + "/below"});
  }
  expect_refused({"synth", "-o", file}, {file});
}

TEST_F(BadInputTest, ContractionsOutsideTheirRange) {
  const std::string table =
      folder_.write("contractions.csv",
                    "frame,timestamp,confidence,success,head_x,head_y,head_scale,head_roll,jaw,"
                    "zygomaticus_major_L,zygomaticus_major_R\n"
                    "0,0,1,1,0,0,1,0,0,0.5,0.5\n"
                    "1,0.04,1,1,0,0,1,0,0,0.5,1.5\n");
  expect_refused(on("animate", table),
                 {table + ":3: column zygomaticus_major_R: '1.5', expected a number in [0, 1]"});
}

TEST_F(BadInputTest, UnknownWordsAndMissingArguments) {
  expect_refused({}, {"no command", "run"});
  expect_refused({"reconstruct"}, {"unknown command 'reconstruct'", "run"});
  expect_refused({"--frobnicate"}, {"unknown option '--frobnicate'"});
  expect_refused({"run"}, {"VIDEO", "required"});
  expect_refused({"run", "a.mp4", "--frobnicate"}, {"--frobnicate"});
  expect_refused({"run", "a.mp4", "b.mp4"}, {"b.mp4"});
  expect_refused({"synth", "--duration", "-1"}, {"--duration", "-1", "range"});
  expect_refused({"synth", "--schedule", "dance"}, {"--schedule", "'dance'", "smile"});
}

TEST(ProgramTest, HelpAndVersionGoToStdout) {
  const ScratchFolder folder;
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, {"--version"}, {"run", "--help"}, {"synth", "-h"}}) {
    const Outcome outcome = run_program(folder, arguments);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

}  // namespace
}  // namespace zygoma
