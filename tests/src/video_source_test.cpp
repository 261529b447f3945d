// Numbered pictures, pipes and cameras as sources: what they give and what is refused.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <future>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "src/base/check.h"
#include "src/io/contours_file.h"
#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "src/synthetic/performer.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

void write_pictures(const ScratchFolder& folder, int first, int last) {
  for (int i = first; i <= last; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "shot_%03d.png", i);
    cv::imwrite(folder / name, cv::Mat(36, 48, CV_8UC3, cv::Scalar::all(10 * i)));
  }
}

std::string refusal(const VideoSource& source) {
  return message_of<InputError>([&] { VideoReader reader(source); });
}

void expect_words(const std::string& message, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), std::string::npos) << "no '" << word << "' in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(NumberedPictures, ComeInOrderAtTheRateAskedFor) {
  const ScratchFolder folder;
  write_pictures(folder, 7, 18);
  for (const double rate : {0.0, 12.5}) {
    VideoSource source(folder / "shot_%03d.png");
    source.frames_per_s = rate;
    const double used = rate > 0.0 ? rate : kUsualPictureRate;
    VideoReader reader(source);
    EXPECT_EQ(reader.info().width_px, 48);
    EXPECT_EQ(reader.info().about_num_frames, 12);
    EXPECT_DOUBLE_EQ(reader.info().average_frames_per_s, used);
    Frame frame;
    int count = 0;
    for (; reader.read(frame); ++count) {
      EXPECT_EQ(frame.index, count);
      EXPECT_NEAR(frame.time_s, count / used, 1e-9);
      EXPECT_EQ(frame.image.at<cv::Vec3b>(5, 5)[0], 10 * (7 + count));
    }
    EXPECT_EQ(count, 12);
    EXPECT_FALSE(reader.has_time_stamps());
    EXPECT_FALSE(reader.ended_early());
    EXPECT_TRUE(reader.repaired_timestamps().empty());
  }
}

TEST(NumberedPictures, MayLieInAFolderWithAPercentSign) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "100%d");
  cv::imwrite(folder / "100%d/0.png", cv::Mat(16, 16, CV_8UC3, cv::Scalar::all(9)));
  VideoReader reader(folder / "100%d/%d.png");
  Frame frame;
  EXPECT_TRUE(reader.read(frame));
  EXPECT_FALSE(reader.read(frame));
}

TEST(NumberedPictures, AreRefusedWithAReason) {
  const ScratchFolder folder;
  write_pictures(folder, 0, 3);
  write_pictures(folder, 5, 6);
  expect_words(refusal(folder / "shot_%03d.png"), {"shot_%03d.png", "picture 4 is missing"});
  expect_words(refusal(folder / "shot_%05d.png"), {"shot_%05d.png", "no picture has such a name"});
  expect_words(refusal(folder / "missing/shot_%03d.png"), {"no picture has such a name"});
  folder.write("text_0.png", "no picture");
  expect_words(refusal(folder / "text_%d.png"), {"text_%d.png", "expected"});
  expect_words(refusal(folder / "shot_%x.png"), {"no such file"});
  expect_words(refusal(folder / ""), {"is a folder", "%04d.png"});
  VideoSource fast(folder / "shot_%03d.png");
  fast.frames_per_s = 5000.0;
  expect_words(refusal(fast), {"frame rate is 5000", "expected 0.1 to 1000"});
}

TEST(VideoFile, KeepsItsOwnTime) {
  const ScratchFolder folder;
  VideoWriter writer(folder / "clip.mp4", 64, 48, 25.0);
  writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(9)), 0.0);
  writer.finish();
  VideoSource source(folder / "clip.mp4");
  source.frames_per_s = 50.0;
  expect_words(refusal(source), {"clip.mp4", "has time stamps of its own"});
}

TEST(LiveCamera, IsRefusedWithAReasonWhereThereIsNone) {
  const ScratchFolder folder;
  VideoSource camera = camera_source(250);
  EXPECT_EQ(camera.path, "/dev/video250");
  EXPECT_FALSE(can_be_read_again(camera));
  expect_words(refusal(camera), {"/dev/video250", "no such camera", "expected"});
  camera.camera_size = "640by480";
  expect_words(refusal(camera), {"'640by480'", "WIDTHxHEIGHT"});
  // Something that is there and no camera reaches the device layer itself.
  camera.camera_size = "640x480";
  camera.path = folder.write("not_a_camera", "text");
  expect_words(refusal(camera), {"not_a_camera", "camera"});
}

// A clip of a performer, small enough to be tracked in a second or two.
std::string write_performer(const ScratchFolder& folder) {
  PerformerOptions options;
  options.schedule = "smile";
  options.duration_s = 0.8;
  options.width_px = 320;
  options.height_px = 240;
  options.num_surface_vertices = 300;
  Performer performer(options);
  const std::string path = folder / "clip.mp4";
  VideoWriter writer(path, options.width_px, options.height_px, options.frames_per_s);
  Frame frame;
  Contractions contractions;
  ContourSet contours;
  while (performer.next(frame, contractions, contours)) writer.write(frame.image, frame.time_s);
  writer.finish();
  return path;
}

int num_pictures(const std::string& video) {
  VideoReader reader(video);
  Frame frame;
  int count = 0;
  while (reader.read(frame)) ++count;
  return count;
}

// What comes only once is tracked exactly as a file is, and kept.
TEST(Pipe, IsTrackedLikeTheFileAndRecorded) {
  const ScratchFolder folder;
  const std::string clip = write_performer(folder);
  ASSERT_EQ(run_program(folder, {"track", clip, "-o", folder / "file", "--no-overlay"}).code, 0);

  const std::string pipe = folder / "pipe.mp4";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  RunningProgram program(folder, {"track", pipe, "-o", folder / "once"});
  std::thread feeder([&] { std::ofstream(pipe, std::ios::binary) << bytes_of(clip); });
  const Outcome outcome = program.finish();
  feeder.join();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(bytes_of(folder / "once/contours.csv"), bytes_of(folder / "file/contours.csv"));
  for (const char* name : {"once/recording.mp4", "once/overlay.mp4"}) {
    EXPECT_EQ(num_pictures(folder / name), 24) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "file/recording.mp4"));

  const Outcome refused = run_program(folder, {"run", pipe, "-o", folder / "run"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("can be read once only"), std::string::npos) << refused.err;
}

// A live source that is stopped: what was tracked until then is there, picture by picture.
TEST(Pipe, KeepsWhatItHasWhenStopped) {
  std::signal(SIGPIPE, SIG_IGN);  // the program leaves while it is still being fed
  const ScratchFolder folder;
  const std::string bytes = bytes_of(write_performer(folder));
  const std::string pipe = folder / "pipe.mp4";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  RunningProgram program(folder, {"track", pipe, "-o", folder / "out"});
  std::promise<void> stopped;
  std::thread feeder([&] {
    std::ofstream live(pipe, std::ios::binary);
    const auto most = static_cast<std::streamsize>(bytes.size() * 2 / 3);
    live.write(bytes.data(), most).flush();
    stopped.get_future().wait();
    live.write(bytes.data() + most, static_cast<std::streamsize>(bytes.size()) - most).flush();
  });
  program.wait_for(folder / "out/recording.mp4.part");
  program.press_ctrl_c();
  stopped.set_value();
  const Outcome outcome = program.finish();
  feeder.join();
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  const auto num_frames = static_cast<int>(read_contours_csv(folder / "out/contours.csv").size());
  EXPECT_GT(num_frames, 0);
  EXPECT_LT(num_frames, 24);
  EXPECT_EQ(num_pictures(folder / "out/recording.mp4"), num_frames);
  EXPECT_FALSE(std::filesystem::exists(folder / "out/overlay.mp4"));
}

TEST(TrackCommand, EndsAfterItsDuration) {
  const ScratchFolder folder;
  const std::string clip = write_performer(folder);
  const Outcome outcome =
      run_program(folder, {"track", clip, "-o", folder / "out", "--duration", "0.25"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(read_contours_csv(folder / "out/contours.csv").size(), 8U);  // 0 to 0.233 s
}

TEST(TrackCommand, RefusesSourcesThatContradictEachOther) {
  const ScratchFolder folder;
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"track"}, "no video given"},
      {{"track", "--camera", "250"}, "no such camera"},
      {{"track", "--camera", "300"}, "300"},
      {{"track", "clip.mp4", "--camera", "0"}, "a video is given too"},
      {{"track", "clip.mp4", "--camera-size", "640x480"}, "needs --camera"},
      {{"track", "%04d.png", "--frame-rate", "2000"}, "2000"},
      {{"track", "%04d.png", "--duration", "-1"}, "-1"},
      {{"track", "%04d.png"}, "no picture has such a name"},
  };
  for (auto [arguments, words] : cases) {
    arguments.insert(arguments.end(), {"-o", folder / "out"});
    const Outcome outcome = run_program(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << words;
    EXPECT_EQ(num_lines(outcome.err), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << words;
  }
}

}  // namespace
}  // namespace zygoma
