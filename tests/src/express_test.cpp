// zygoma express, zygoma face, and keyframes: what they write is what was asked for.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "face/facs.h"
#include "face/muscle_table.h"
#include "src/io/scene_file.h"
#include "src/io/video_reader.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

// Mean over the pixels.
double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

TEST(ExpressTest, ShowsTheExpressionOnTheSideAskedFor) {
  const ScratchFolder folder;
  const auto picture = [&](const std::string& text, const std::string& name) {
    const Outcome outcome =
        run_program(folder, {"express", text, "-o", folder / name, "--no-bars", "--height", "240"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find(name), std::string::npos);
    return cv::imread(folder / name);
  };
  const cv::Mat rest = picture("neutral", "rest.png");
  ASSERT_EQ(rest.size(), cv::Size(192, 240));
  const cv::Mat left = picture("L12", "left.png");
  // The subject's left is on the right of the picture.
  const cv::Rect right_half(0, 0, 90, 240);
  const cv::Rect left_half(102, 0, 90, 240);
  EXPECT_GT(difference(rest(left_half), left(left_half)),
            5.0 * difference(rest(right_half), left(right_half)));
  EXPECT_EQ(difference(picture("12", "a.png"), picture("zygomaticus_major=1", "b.png")), 0.0);
}

TEST(ExpressTest, ViewsAndOverlaysShowSomethingElse) {
  const ScratchFolder folder;
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "express", "12", "-o", folder / "face.png", "--no-bars", "--height", "240"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run_program(folder, arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return cv::imread(folder / "face.png");
  };
  std::vector<cv::Mat> pictures{picture({})};
  for (const char* view : {"three-quarter", "profile"})
    pictures.push_back(picture({"--view", view}));
  for (const char* overlay : {"lattice", "muscles", "volume", "strain"}) {
    pictures.push_back(picture({"--overlay", overlay}));
  }
  for (std::size_t a = 0; a < pictures.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) EXPECT_GT(difference(pictures[a], pictures[b]), 0.5);
  }
}

TEST(ExpressTest, SaysWhichQualityItPicked) {
  const ScratchFolder folder;
  const auto says = [&](const std::string& option, const std::string& value) {
    const Outcome outcome = run_program(folder,
                                        {"express",
                                         "12",
                                         "-o",
                                         folder / "face.png",
                                         "--no-bars",
                                         "--height",
                                         "240",
                                         option,
                                         value});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_NE(says("--quality", "draft").find("quality draft"), std::string::npos);
  EXPECT_EQ(says("--quality", "standard").find("quality"), std::string::npos);
  EXPECT_NE(says("--tolerance", "5").find("quality draft"), std::string::npos);
  const std::string tight = says("--budget", "0.001");
  EXPECT_NE(tight.find("cannot be met"), std::string::npos) << tight;
  EXPECT_NE(tight.find("not met"), std::string::npos) << tight;
}

TEST(ExpressTest, FilmsTheWayThereAndBack) {
  const ScratchFolder folder;
  const std::string video = folder / "smile.mp4";
  const Outcome outcome =
      run_program(folder, {"express", "6+12", "-o", video, "--no-bars", "--height", "240"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  VideoReader reader(video);
  std::vector<cv::Mat> pictures;
  for (Frame frame; reader.read(frame);) pictures.push_back(frame.image.clone());
  ASSERT_EQ(pictures.size(), 70U);
  const auto mouth = [&](std::size_t k) { return pictures[k](cv::Rect(56, 130, 80, 50)); };
  EXPECT_GT(difference(mouth(0), mouth(35)), 4.0 * difference(mouth(0), mouth(69)));
}

TEST(ExpressTest, KeyframesTakePosesAndSingleMuscles) {
  const ScratchFolder folder;
  const std::string file = folder.write("keys.json", R"({
    "frames_per_s": 20,
    "keys": [{"time_s": 0},
             {"time_s": 0.2, "pose": "surprise", "contractions": {"occipitofrontalis_inner_L": 0.3}},
             {"time_s": 0.4, "pose": "R12A+26", "jaw": 0.8}]})");
  const Motion motion = read_keyframes(file);
  ASSERT_EQ(motion.keys.size(), 3U);
  Pose surprise = pose_of("surprise");
  surprise.contraction["occipitofrontalis_inner_L"] = 0.3;
  EXPECT_EQ(motion.keys[1].contraction, surprise.contraction);
  EXPECT_EQ(motion.keys[1].jaw, surprise.jaw);
  EXPECT_EQ(motion.keys[2].contraction, pose_of("R12A").contraction);
  EXPECT_EQ(motion.keys[2].jaw, 0.8);
  const Outcome outcome =
      run_program(folder, {"animate", file, "-o", folder / "a.mp4", "--height", "240"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("9 frames"), std::string::npos) << outcome.out;
}

TEST(ExpressTest, TheListNamesEverything) {
  const ScratchFolder folder;
  const Outcome outcome = run_program(folder, {"face", "list"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const std::string& muscle : standard_muscle_names()) {
    EXPECT_NE(outcome.out.find(muscle + "\n"), std::string::npos) << muscle;
  }
  for (const Expression& expression : expressions()) {
    EXPECT_NE(outcome.out.find("\n" + expression.name + " "), std::string::npos);
  }
  for (const ActionUnit& unit : action_units()) {
    EXPECT_NE(outcome.out.find(" " + std::string(unit.name) + " "), std::string::npos);
  }
  const Outcome muscles = run_program(folder, {"face", "list", "muscles"});
  EXPECT_EQ(num_lines(muscles.out), static_cast<int>(standard_muscle_names().size()));
}

TEST(ExpressTest, TheSheetHasATileForEverything) {
  const ScratchFolder folder;
  const std::string sheet = folder / "sheet.png";
  const Outcome outcome =
      run_program(folder, {"face", "sheet", "-o", sheet, "--tile", "64", "--columns", "10"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::size_t num_faces = expressions().size() + action_units().size();
  EXPECT_EQ(outcome.out.find(std::to_string(num_faces) + " faces"), 0U) << outcome.out;
  EXPECT_EQ(outcome.err.find("inside out"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("not fully settled"), std::string::npos) << outcome.err;
  const cv::Mat picture = cv::imread(sheet);
  EXPECT_GE(picture.cols, 10 * 51);
}

}  // namespace
}  // namespace zygoma
