// Video out and in again: pictures, time stamps, sizes, rotation, damaged files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "src/base/check.h"
#include "src/io/video_clock.h"
#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/rotation_tag.h"
#include "tracker/picture.h"

namespace zygoma {
namespace {

// A picture that says its number: `number` in binary as eight black or white bars.
cv::Mat numbered_picture(int number, cv::Size size) {
  cv::Mat picture(size, CV_8UC3, cv::Scalar(90, 120, 150));
  for (int bit = 0; bit < 8; ++bit) {
    const int left = bit * size.width / 8;
    const cv::Rect bar(left, 0, (bit + 1) * size.width / 8 - left, size.height / 2);
    picture(bar).setTo((number >> bit & 1) != 0 ? cv::Scalar::all(255) : cv::Scalar::all(0));
  }
  return picture;
}

int number_in(const cv::Mat& picture) {
  int number = 0;
  for (int bit = 0; bit < 8; ++bit) {
    const int x = (2 * bit + 1) * picture.cols / 16;
    if (picture.at<cv::Vec3b>(picture.rows / 4, x)[1] > 128) number |= 1 << bit;
  }
  return number;
}

void write_clip(const std::string& path, const std::vector<double>& times_s, cv::Size size) {
  VideoWriter writer(path, size.width, size.height, 25.0, {"ultrafast", 20, 1});
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    writer.write(numbered_picture(static_cast<int>(i), size), times_s[i]);
  }
  writer.finish();
}

std::vector<double> constant_rate(int num_frames, double frames_per_s) {
  std::vector<double> times_s;
  for (int i = 0; i < num_frames; ++i) times_s.push_back(i / frames_per_s);
  return times_s;
}

std::string refusal(const std::string& path) {
  return message_of<InputError>([&] { VideoReader reader(path); });
}

void expect_words(const std::string& message, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(message.find(word), std::string::npos) << "no '" << word << "' in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

TEST(VideoClockTest, KeepsStampsThatIncreaseAndStartsAtZero) {
  VideoClock clock(25.0);
  EXPECT_EQ(clock.next(0.5), 0.0);
  EXPECT_DOUBLE_EQ(clock.next(0.54), 0.54 - 0.5);
  EXPECT_DOUBLE_EQ(clock.next(0.98), 0.98 - 0.5);  // a hole stays a hole
  EXPECT_TRUE(clock.repaired().empty());
  EXPECT_TRUE(clock.has_time());
}

TEST(VideoClockTest, ContinuesAZeroTailWithTheLastStep) {
  VideoClock clock(30.0);
  clock.next(0.0);
  clock.next(0.1);
  clock.next(0.15);
  EXPECT_NEAR(clock.next(0.0), 0.20, 1e-12);
  EXPECT_NEAR(clock.next(0.0), 0.25, 1e-12);
  EXPECT_NEAR(clock.next(std::nan("")), 0.30, 1e-12);
  EXPECT_EQ(clock.repaired(), (std::vector<int>{3, 4, 5}));
  EXPECT_TRUE(clock.has_time());
}

TEST(VideoClockTest, CountsPicturesWhenTheStreamHasNoTime) {
  VideoClock clock(25.0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(clock.next(0.0), i / 25.0);
  EXPECT_FALSE(clock.has_time());
}

TEST(VideoTest, ReadsBackPicturesInOrderWithTheirTimes) {
  const ScratchFolder folder;
  const std::string path = folder / "clip.mp4";
  const std::vector<double> times_s = constant_rate(40, 30000.0 / 1001.0);
  write_clip(path, times_s, {96, 64});

  VideoReader reader(path);
  EXPECT_EQ(reader.info().width_px, 96);
  EXPECT_EQ(reader.info().height_px, 64);
  EXPECT_EQ(reader.info().rotation_deg, 0);
  EXPECT_EQ(reader.info().pixel_aspect, 1.0);
  EXPECT_NEAR(reader.info().about_num_frames, 40, 1);
  EXPECT_NEAR(reader.info().average_frames_per_s, 30000.0 / 1001.0, 0.01);
  Frame frame;
  int count = 0;
  while (reader.read(frame)) {
    ASSERT_LT(count, 40);
    EXPECT_EQ(frame.index, count);
    EXPECT_EQ(number_in(frame.image), count);
    EXPECT_NEAR(frame.time_s, times_s[count], 1e-4);
    ++count;
  }
  EXPECT_EQ(count, 40);
  EXPECT_FALSE(reader.ended_early());
  EXPECT_TRUE(reader.has_time_stamps());
  EXPECT_FALSE(reader.read(frame));
}

TEST(VideoTest, KeepsTheStampsOfTheLastPicturesBehindBFrames) {
  const ScratchFolder folder;
  const std::string path = folder / "b_frames.mp4";
  std::vector<double> times_s = constant_rate(30, 25.0);
  times_s.back() += 0.7;  // not where a constant rate would have it
  VideoWriter writer(path, 96, 64, 25.0, {"veryfast", 20, 1});  // this preset uses B-frames
  for (int i = 0; i < 30; ++i) writer.write(numbered_picture(i, {96, 64}), times_s[i]);
  writer.finish();

  VideoReader reader(path);
  Frame frame;
  while (reader.read(frame)) {
    EXPECT_EQ(number_in(frame.image), frame.index);
    EXPECT_NEAR(frame.time_s, times_s[frame.index], 1e-4);
  }
  EXPECT_EQ(frame.index, 29);
  EXPECT_TRUE(reader.repaired_timestamps().empty());
}

TEST(VideoTest, KeepsAVariableRateAndHoles) {
  const ScratchFolder folder;
  const std::string path = folder / "variable.mp4";
  std::vector<double> times_s;
  for (int i = 0; i < 15; ++i) times_s.push_back(i / 30.0);
  for (int i = 0; i < 15; ++i) times_s.push_back(1.25 + i / 15.0);
  write_clip(path, times_s, {64, 48});

  VideoReader reader(path);
  Frame frame;
  std::vector<double> read_s;
  while (reader.read(frame)) read_s.push_back(frame.time_s);
  ASSERT_EQ(read_s.size(), times_s.size());
  for (std::size_t i = 0; i < times_s.size(); ++i) EXPECT_NEAR(read_s[i], times_s[i], 1e-4) << i;
}

TEST(VideoTest, RoundsOddSizesUpByRepeatingTheEdge) {
  const ScratchFolder folder;
  const std::string path = folder / "odd.mp4";
  cv::Mat picture(33, 61, CV_8UC3, cv::Scalar::all(30));
  picture.colRange(40, 61).setTo(cv::Scalar::all(220));
  VideoWriter writer(path, 61, 33, 25.0, {"ultrafast", 5, 1});
  for (int i = 0; i < 3; ++i) writer.write(picture, i / 25.0);
  writer.finish();

  VideoReader reader(path);
  Frame frame;
  ASSERT_TRUE(reader.read(frame));
  EXPECT_EQ(frame.image.size(), cv::Size(62, 34));
  EXPECT_NEAR(frame.image.at<cv::Vec3b>(33, 61)[1], 220, 8);
  EXPECT_NEAR(frame.image.at<cv::Vec3b>(33, 5)[1], 30, 8);
}

TEST(VideoTest, KeepsColours) {
  const ScratchFolder folder;
  const std::string path = folder / "colour.mp4";
  const std::vector<cv::Vec3b> colours{
      {200, 60, 40}, {40, 180, 60}, {90, 120, 200}, {128, 128, 128}};
  cv::Mat picture(48, 128, CV_8UC3);
  for (int i = 0; i < 4; ++i) picture.colRange(32 * i, 32 * i + 32).setTo(cv::Scalar(colours[i]));
  VideoWriter writer(path, 128, 48, 25.0, {"ultrafast", 5, 1});
  writer.write(picture, 0.0);
  writer.finish();

  VideoReader reader(path);
  Frame frame;
  ASSERT_TRUE(reader.read(frame));
  for (int i = 0; i < 4; ++i) {
    const cv::Vec3b seen = frame.image.at<cv::Vec3b>(24, 32 * i + 16);
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(seen[channel], colours[i][channel], 6)
          << "colour " << i << " channel " << channel;
    }
  }
}

TEST(VideoTest, SameInputGivesTheSameFile) {
  const ScratchFolder folder;
  write_clip(folder / "a.mp4", constant_rate(20, 25.0), {64, 48});
  write_clip(folder / "b.mp4", constant_rate(20, 25.0), {64, 48});
  EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "b.mp4"));
}

TEST(VideoTest, AppliesTheRotationTag) {
  const ScratchFolder folder;
  const std::string path = folder / "rotated.mp4";
  cv::Mat picture(48, 96, CV_8UC3, cv::Scalar::all(20));
  picture(cv::Rect(0, 0, 24, 24)).setTo(cv::Scalar::all(240));  // top left
  VideoWriter writer(path, 96, 48, 25.0, {"ultrafast", 10, 1});
  for (int i = 0; i < 3; ++i) writer.write(picture, i / 25.0);
  writer.finish();
  tag_as_rotated(path);

  VideoReader reader(path);
  EXPECT_EQ(reader.info().width_px, 48);
  EXPECT_EQ(reader.info().height_px, 96);
  EXPECT_EQ(reader.info().rotation_deg, 90);
  Frame frame;
  ASSERT_TRUE(reader.read(frame));
  EXPECT_EQ(frame.image.size(), cv::Size(48, 96));
  EXPECT_GT(frame.image.at<cv::Vec3b>(12, 36)[1], 200);  // turned clockwise: top right
  EXPECT_LT(frame.image.at<cv::Vec3b>(12, 12)[1], 60);
}

TEST(VideoTest, ReadsWhatIsLeftOfATruncatedFile) {
  const ScratchFolder folder;
  const std::string whole = folder / "whole.mp4";
  write_clip(whole, constant_rate(100, 25.0), {96, 64});
  const std::string bytes = bytes_of(whole);
  const std::string cut = folder.write("cut.mp4", bytes.substr(0, bytes.size() * 6 / 10));

  testing::internal::CaptureStderr();
  VideoReader reader(cut);
  Frame frame;
  int count = 0;
  while (reader.read(frame)) {
    EXPECT_EQ(number_in(frame.image), count);
    EXPECT_NEAR(frame.time_s, count / 25.0, 1e-4);
    ++count;
  }
  EXPECT_GT(count, 20);
  EXPECT_LT(count, 95);
  EXPECT_TRUE(reader.ended_early());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(VideoTest, RefusesWhatIsNoVideoAndSaysWhy) {
  const ScratchFolder folder;
  const std::string missing = folder / "missing.mp4";
  const std::string text = folder.write("text.mp4", std::string(5000, 'x') + "\nno video\n");
  const std::string notes = folder.write("notes.txt", "FFmpeg would draw this as a terminal\n");
  const std::string empty = folder.write("empty.mp4", "");
  const std::string whole = folder / "whole.mp4";
  write_clip(whole, constant_rate(5, 25.0), {64, 48});
  const std::string stump = folder.write("stump.mp4", bytes_of(whole).substr(0, 200));

  testing::internal::CaptureStderr();
  expect_words(refusal(missing), {missing, "no such file", "expected a video"});
  expect_words(refusal(folder / ""), {"is a folder", "expected a video"});
  expect_words(refusal(text), {text, "cannot be read as a video", "expected a video"});
  expect_words(refusal(notes), {notes, "cannot be read as a video"});
  expect_words(refusal(empty), {empty, "is empty", "expected a video"});
  expect_words(refusal(stump), {stump, "expected a video"});
  expect_words(refusal("/dev/null"), {"/dev/null", "not a regular file"});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the libraries must be silent";
}

TEST(VideoTest, ReadsAFileWhoseNameLooksLikeAnAddress) {
  const ScratchFolder folder;
  write_clip(folder / "take1:2.mp4", constant_rate(3, 25.0), {64, 48});
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder / "");
  Frame frame;
  EXPECT_TRUE(VideoReader("take1:2.mp4").read(frame));
  std::filesystem::current_path(before);
}

TEST(VideoTest, LeavesNoFileBehindUnlessFinished) {
  const ScratchFolder folder;
  const std::string path = folder / "half.mp4";
  {
    VideoWriter writer(path, 64, 48, 25.0);
    writer.write(numbered_picture(0, {64, 48}), 0.0);
    EXPECT_TRUE(std::filesystem::exists(path + ".part"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(VideoTest, RefusesToWriteWhereItCannot) {
  const ScratchFolder folder;
  const auto refused = [](const std::string& path) {
    return message_of<InputError>([&] { VideoWriter writer(path, 64, 48, 25.0); });
  };
  expect_words(refused(folder / "missing/clip.mp4"), {"missing/clip.mp4", "cannot be written"});
  expect_words(refused(folder / ""), {"is a folder"});
}

TEST(VideoTest, ReportsADiskThatIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full here";
  const ScratchFolder folder;
  const std::string path = folder / "full.mp4";
  std::filesystem::create_symlink("/dev/full", path + ".part");
  const std::string message = message_of<InputError>([&] {
    VideoWriter writer(path, 320, 240, 25.0, {"ultrafast", 1, 1});
    cv::RNG random(1);
    cv::Mat noise(240, 320, CV_8UC3);
    for (int i = 0; i < 20; ++i) {
      random.fill(noise, cv::RNG::UNIFORM, 0, 256);
      writer.write(noise, i / 25.0);
    }
    writer.finish();
  });
  expect_words(message, {path, "cannot be written"});
  EXPECT_FALSE(std::filesystem::exists(path));
}

// The same pictures at the same times, whichever way they are asked for; each stays what it is
// while later ones are read.
TEST(VideoTest, PlanesAreThePicturesAsStored) {
  const ScratchFolder folder;
  const std::string path = folder / "clip.mp4";
  const cv::Size size(320, 180);
  write_clip(path, constant_rate(30, 25.0), size);
  VideoReader converted(path), stored(path), mixed(path);
  std::vector<Frame> frames;
  Frame frame, other;
  while (stored.read_planes(frame)) {
    EXPECT_TRUE(frame.image.empty());
    frames.push_back(frame);
  }
  ASSERT_EQ(frames.size(), 30U);
  for (const Frame& planes : frames) {
    ASSERT_TRUE(converted.read(frame));
    EXPECT_EQ(planes.index, frame.index);
    EXPECT_EQ(planes.time_s, frame.time_s);
    EXPECT_EQ(number_in(Picture(planes).bgr()), planes.index);
    EXPECT_LT(cv::norm(Picture(planes).bgr(), frame.image, cv::NORM_L1) / (3.0 * size.area()), 2.0);
    ASSERT_TRUE(planes.index % 3 == 0 ? mixed.read(other) : mixed.read_planes(other));
    EXPECT_EQ(other.index, planes.index);
    EXPECT_EQ(other.image.empty(), planes.index % 3 != 0);
  }
  EXPECT_FALSE(converted.read(frame));
}

}  // namespace
}  // namespace zygoma
