// The program itself, given what it cannot use: exit code 2, one line on stderr that names what is
// wrong, nothing on stdout and nothing left behind. Given what it can use in part: what there is.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "src/synthetic/performer.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

using Names = std::set<std::string>;

Names files_in(const std::string& folder) {
  Names names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

std::string write_clip(const std::string& path, const std::vector<cv::Mat>& pictures) {
  constexpr double kRate = 30.0;
  VideoWriter writer(path, pictures.front().cols, pictures.front().rows, kRate);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    writer.write(pictures[i], static_cast<double>(i) / kRate);
  }
  writer.finish();
  return path;
}

std::vector<cv::Mat> noise(int width_px, int height_px, int num_frames) {
  std::vector<cv::Mat> pictures;
  cv::RNG random(7);
  for (int i = 0; i < num_frames; ++i) {
    pictures.emplace_back(height_px, width_px, CV_8UC3);
    random.fill(pictures.back(), cv::RNG::UNIFORM, 0, 256);
  }
  return pictures;
}

// A face at rest; a few frames are drawn and shown forwards and backwards.
std::vector<cv::Mat> face(int num_frames) {
  PerformerOptions options;
  options.schedule = "neutral";
  options.width_px = 320;
  options.height_px = 240;
  options.num_surface_vertices = 300;
  Performer performer(options);
  std::vector<cv::Mat> drawn;
  Frame frame;
  Contractions contractions;
  ContourSet contours;
  while (static_cast<int>(drawn.size()) < std::min(num_frames, 6) &&
         performer.next(frame, contractions, contours)) {
    drawn.push_back(frame.image.clone());
  }
  std::vector<cv::Mat> pictures;
  const int period = std::max(1, 2 * static_cast<int>(drawn.size()) - 2);
  for (int i = 0; i < num_frames; ++i) {
    const int phase = i % period;
    pictures.push_back(drawn[std::min(phase, period - phase)]);
  }
  return pictures;
}

int num_pictures(const std::string& video) {
  VideoReader reader(video);
  Frame frame;
  int count = 0;
  while (reader.read(frame)) ++count;
  return count;
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
    const std::string complaint = without_progress(outcome.err);
    EXPECT_EQ(num_lines(complaint), 1) << outcome.err;
    EXPECT_TRUE(complaint.starts_with("zygoma: ")) << outcome.err;
    for (const std::string& word : words) {
      EXPECT_NE(complaint.find(word), std::string::npos) << "no '" << word << "' in: " << complaint;
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "left behind";
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
  const std::string video = write_clip(folder_ / "noise.mp4", noise(64, 64, 2));
  expect_refused({"run", video, "-o", folder_ / "out", "--truth", missing_table}, {missing_table});
  expect_refused({"run", video, "-o", folder_ / "out", "--init", missing_table}, {missing_table});
  expect_refused({"track", video, "-o", folder_ / "out", "--init", missing_table}, {missing_table});
  expect_refused({"track", video, "-o", folder_ / "out", "--corrections", missing_table},
                 {missing_table, "expected a corrections file"});
  expect_refused({"track", video, "-o", folder_ / "out", "--cascades", missing_table},
                 {missing_table});
}

TEST_F(BadInputTest, QualityThatContradictsItself) {
  const std::string out = folder_ / "face.png";
  expect_refused({"express", "smile", "-o", out, "--quality", "superb"}, {"superb", "draft"});
  expect_refused({"express", "12", "-o", out, "--quality", "fine", "--budget", "3"},
                 {"--budget", "one of them"});
  expect_refused({"express", "12", "-o", out, "--tolerance", "0.3", "--surface-vertices", "500"},
                 {"--surface-vertices"});
  expect_refused({"express", "12", "-o", out, "--budget", "-3"}, {"-3"});
  const std::string clip = ZYGOMA_SOURCE_DIR "/samples/performer.mp4";
  expect_refused({"run", clip, "-o", out, "--budget", "30", "--level", "lattice"},
                 {"--level", "--budget"});
  expect_refused({"run", clip, "-o", out, "--tolerance", "0.3", "--second-look", "all"},
                 {"--second-look", "--tolerance"});
  expect_refused({"run", clip, "-o", out, "--quality", "fine", "--budget", "30"},
                 {"--budget", "one of them"});
  expect_refused({"tradeoff", "-o", out, "--truth", "contractions.csv"}, {"--truth", "clip"});
  expect_refused({"tradeoff", out + "/no_such_clip.mp4", "-o", out}, {"no_such_clip.mp4"});
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
  expect_refused({"synth", "-o", folder_ / "out", "--name", "../up"}, {"--name", "'../up'"});
  expect_refused({"track", video, "-o", "/proc/zygoma/out"}, {"/proc/zygoma/out"});
}

TEST_F(BadInputTest, OutputThatIsTheInput) {
  const std::string bytes = "read while it would be replaced";
  const std::string reconstruction = folder_.write("reconstruction.mp4", bytes);
  const std::string overlay = folder_.write("overlay.mp4", bytes);
  const std::string table = folder_.write("contractions.csv", bytes);
  expect_refused({"run", reconstruction, "-o", folder_ / ""}, {reconstruction, "the input itself"});
  expect_refused({"track", overlay, "-o", folder_ / "."}, {"overlay.mp4", "the input itself"});
  expect_refused({"animate", table, "-o", table}, {table, "the input itself"});
  expect_refused({"animate", table, "--video", overlay, "-o", overlay}, {overlay, "the input"});
  for (const std::string& file : {reconstruction, overlay, table}) {
    EXPECT_EQ(bytes_of(file), bytes);
  }
}

TEST_F(BadInputTest, VideoWithoutAFace) {
  const std::string noisy = write_clip(folder_ / "noise.mp4", noise(320, 240, 10));
  const std::string tiny = write_clip(folder_ / "tiny.mp4", noise(16, 16, 3));
  for (const char* command : {"run", "track"}) {
    expect_refused(on(command, noisy), {noisy, "no face found in 10 frames"});
    expect_refused(on(command, tiny), {tiny, "no face found in 3 frames"});
  }
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

TEST_F(BadInputTest, ContractionsWithAGap) {
  const std::string head =
      "frame,timestamp,confidence,success,head_x,head_y,head_scale,head_roll,jaw,"
      "zygomaticus_major_L,zygomaticus_major_R\n"
      "0,0,1,1,0,0,1,0,0,0.5,0.5\n";
  const auto refuse = [&](const std::string& row, const std::vector<std::string>& words) {
    const std::string table = folder_.write("contractions.csv", head + row + "\n");
    expect_refused(on("animate", table), words);
  };
  refuse("2,0.08,1,1,0,0,1,0,0,0.5,0.5", {":3: column frame: '2', expected 1"});
  refuse("1,0,1,1,0,0,1,0,0,0.5,0.5", {":3: column timestamp: '0', expected a later time"});
  refuse("1,0.04,1,1,0,0,1,0,0,0.5,", {":3: column zygomaticus_major_R: empty cell"});
  refuse("1,0.04,1,1,0,0,1,0,,0.5,0.5", {":3: column jaw: empty cell"});
  refuse("1,0.04,1,1,0,0,1,0,0,0.5", {":3: 10 cells, expected 11"});
  const std::string one_side =
      folder_.write("side.csv",
                    "frame,timestamp,confidence,success,head_x,head_y,head_scale,head_roll,jaw,"
                    "zygomaticus_major_L\n0,0,1,1,0,0,1,0,0,0.5\n");
  expect_refused(on("animate", one_side), {"missing column zygomaticus_major_R"});
  const std::string unknown =
      folder_.write("unknown.csv",
                    "frame,timestamp,confidence,success,head_x,head_y,head_scale,head_roll,jaw,"
                    "wing_L,wing_R\n0,0,1,1,0,0,1,0,0,0.5,0.5\n");
  expect_refused(on("animate", unknown), {"'wing_L'", "no muscle of that name"});
}

TEST_F(BadInputTest, Keyframes) {
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    const std::string file = folder_.write("keys.json", text);
    std::vector<std::string> all{file};
    all.insert(all.end(), words.begin(), words.end());
    expect_refused({"animate", file, "-o", folder_ / "out"}, all);
  };
  refuse("", {"not valid JSON"});
  refuse("[]", {"a list of 0", "expected an object"});
  refuse("{}", {"keys", "expected a list of at least one pose"});
  refuse(R"({"keys": []})", {"keys", "at least one pose"});
  refuse(R"({"keys": [{"pose": "6+12"}]})", {"keys[0].time_s", "the time of the pose"});
  refuse(R"({"keys": [{"time_s": 0, "pose": "6+99"}]})", {"keys[0].pose", "no action unit 99"});
  refuse(R"({"keys": [{"time_s": 0, "pose": "joy"}]})", {"keys[0].pose", "'joy' is unknown"});
  refuse(R"({"keys": [{"time_s": 0, "pose": 12}]})", {"keys[0].pose: '12', expected a text"});
  refuse(R"({"keys": [{"time_s": 0, "contractions": {"wing": 1}}]})", {"'wing' is unknown"});
  refuse(R"({"keys": [{"time_s": 0, "contractions": {"mentalis": 1.5}}]})",
         {"mentalis_L is 1.5, expected 0 to 1"});
  refuse(R"({"keys": [{"time_s": 0, "jaw": -1}]})", {"keys[0].jaw is -1, expected 0 to 1"});
  refuse(R"({"keys": [{"time_s": 1}, {"time_s": 1}]})", {"keys[1].time_s", "later than the key"});
  refuse(R"({"frames_per_s": 0, "keys": [{"time_s": 0}]})", {"frames_per_s is 0"});
  refuse(R"({"frames": 3, "keys": [{"time_s": 0}]})", {"'frames' is unknown"});
  const std::string good = folder_.write("good.json", R"({"keys": [{"time_s": 0}]})");
  expect_refused({"animate", good, "--video", good, "-o", folder_ / "out"}, {"--video"});
  expect_refused({"animate", good, "-o", good}, {good, "the input itself"});
}

TEST_F(BadInputTest, Expressions) {
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    expect_refused({"express", text, "-o", folder_ / "out.png"}, words);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.png"));
  };
  refuse("joy", {"expression 'joy' is unknown", "happiness"});
  refuse("26+27", {"26 and 27 exclude each other"});
  refuse("12+12", {"action unit 12 is there twice"});
  refuse("12:150%", {"150, expected 0 to 100"});
  refuse("wing=1", {"muscle 'wing' is unknown"});
  refuse("mentalis=1.5", {"mentalis is 1.5, expected 0 to 1"});
  refuse("", {"no expression"});
  expect_refused({"express", "12", "-o", folder_ / "out.gif"}, {"out.gif", ".png"});
  expect_refused({"express", "12", "--jaw", "60", "-o", folder_ / "out.png"}, {"--jaw", "60"});
  expect_refused({"express", "12", "--with", "magic", "-o", folder_ / "out.png"}, {"magic"});
  expect_refused({"express", "12", "--scene", folder_ / "none.json"}, {"none.json"});
  const std::string scene = folder_.write("s.json", R"({"motion": {"keys": [{"time_s": 0}]}})");
  expect_refused({"express", "12", "--scene", scene, "--surface-vertices", "500"},
                 {"--surface-vertices", "the scene"});
  expect_refused({"face"}, {"WHAT", "required"});
  expect_refused({"face", "dance"}, {"'dance'", "list or sheet"});
  expect_refused({"face", "list", "bones"}, {"'bones'", "muscles, aus or expressions"});
  expect_refused({"face", "sheet", "-o", folder_ / "sheet.pdf"}, {"sheet.pdf", ".png"});
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

TEST(ProgramTest, OneFrameIsAClip) {
  const ScratchFolder folder;
  const std::string clip = write_clip(folder / "one.mp4", face(1));
  const Outcome outcome =
      run_program(folder, {"run", clip, "-o", folder / "out", "--surface-vertices", "300"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(files_in(folder / "out"),
            (Names{"contours.csv",
                   "contractions.csv",
                   "contractions.svg",
                   "reconstruction.mp4",
                   "retarget_report.json",
                   "session.json"}));
  EXPECT_EQ(read_contours_csv(folder / "out/contours.csv").size(), 1U);
  EXPECT_EQ(read_contractions_csv(folder / "out/contractions.csv").frames.size(), 1U);
  EXPECT_EQ(num_pictures(folder / "out/reconstruction.mp4"), 1);
}

TEST(ProgramTest, TakesWhatATruncatedFileStillHolds) {
  const ScratchFolder folder;
  const std::string whole = bytes_of(write_clip(folder / "whole.mp4", face(60)));
  const std::string cut = folder.write("cut.mp4", whole.substr(0, whole.size() * 6 / 10));
  const Outcome outcome = run_program(folder, {"track", cut, "-o", folder / "out"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto num_frames = read_contours_csv(folder / "out/contours.csv").size();
  EXPECT_GE(num_frames, 2U);
  EXPECT_LT(num_frames, 60U);
  const std::string remark =
      cut + ": ends after " + std::to_string(num_frames) + " frames, the file claims about 60";
  EXPECT_NE(outcome.err.find(remark), std::string::npos) << outcome.err;
  EXPECT_EQ(files_in(folder / "out"), (Names{"contours.csv", "overlay.mp4", "session.json"}));
  EXPECT_EQ(num_pictures(folder / "out/overlay.mp4"), static_cast<int>(num_frames));
}

TEST(ProgramTest, AFailureLeavesEarlierResultsAlone) {
  const ScratchFolder folder;
  const std::string good = write_clip(folder / "good.mp4", face(2));
  const std::string bad = write_clip(folder / "bad.mp4", noise(64, 64, 2));
  ASSERT_EQ(run_program(folder, {"track", good, "-o", folder / "out"}).code, 0);
  const std::string before = bytes_of(folder / "out/contours.csv");
  const Names files = files_in(folder / "out");
  EXPECT_EQ(run_program(folder, {"track", bad, "-o", folder / "out"}).code, 2);
  EXPECT_EQ(bytes_of(folder / "out/contours.csv"), before);
  EXPECT_EQ(files_in(folder / "out"), files);
}

TEST(ProgramTest, CtrlCWhileTrackingKeepsTheFramesDone) {
  const ScratchFolder folder;
  const std::string clip = write_clip(folder / "clip.mp4", face(120));
  RunningProgram program(folder, {"run", clip, "-o", folder / "out"});
  ASSERT_TRUE(program.wait_for(folder / "out"));
  program.press_ctrl_c();
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  ASSERT_EQ(files_in(folder / "out"), (Names{"contours.csv", "session.json"})) << outcome.err;
  const auto num_frames = read_contours_csv(folder / "out/contours.csv").size();
  EXPECT_GE(num_frames, 1U);
  EXPECT_LT(num_frames, 120U);
}

TEST(ProgramTest, CtrlCWhileAnimatingKeepsTheVideoSoFar) {
  const ScratchFolder folder;
  const std::string clip = write_clip(folder / "clip.mp4", face(60));
  RunningProgram program(folder,
                         {"run",
                          clip,
                          "-o",
                          folder / "out",
                          "--method",
                          "closed-form",
                          "--surface-vertices",
                          "300",
                          "--samples",
                          "1"});
  ASSERT_TRUE(program.wait_for(folder / "out/reconstruction.mp4.part"));
  program.press_ctrl_c();
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  ASSERT_EQ(files_in(folder / "out"),
            (Names{"contours.csv",
                   "contractions.csv",
                   "contractions.svg",
                   "reconstruction.mp4",
                   "retarget_report.json",
                   "session.json"}))
      << outcome.err;
  EXPECT_EQ(read_contours_csv(folder / "out/contours.csv").size(), 60U);
  EXPECT_EQ(read_contractions_csv(folder / "out/contractions.csv").frames.size(), 60U);
  const int num_animated = num_pictures(folder / "out/reconstruction.mp4");
  EXPECT_GE(num_animated, 1);
  EXPECT_LT(num_animated, 60);
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
