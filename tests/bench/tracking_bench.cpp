// The tracker alone: processor time per frame at 640x480 on one core against 60 frames/s, the whole
// pass at 1280x720 against decoding alone, and the largest memory over ten minutes.
//
//   tracking_bench [--csv RESULT.csv] VIDEO...
//
// Clips are fitted into the size wanted with borders. Repeats alternate what is compared; medians
// are reported. The memory is that of a process of its own, whose clip is the first video shown
// forwards and backwards.
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "src/io/video_writer.h"
#include "src/pipeline/track_video.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/silent_observer.h"

namespace zygoma {
namespace {

using bench::format;
using bench::median;

constexpr int kRepeats = 5;
constexpr int kMostFrames = 240;  // of a clip
constexpr double kLongClip_s = 600.0;

std::vector<Frame> fitted_frames(const std::string& video, cv::Size size) {
  VideoReader reader(video);
  std::vector<Frame> frames;
  Frame frame;
  while (static_cast<int>(frames.size()) < kMostFrames && reader.read(frame)) {
    const double scale = std::min(static_cast<double>(size.width) / frame.image.cols,
                                  static_cast<double>(size.height) / frame.image.rows);
    cv::Mat fitted;
    cv::resize(
        frame.image, fitted, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC);
    const int right = std::max(0, size.width - fitted.cols);
    const int bottom = std::max(0, size.height - fitted.rows);
    cv::copyMakeBorder(fitted, fitted, 0, bottom, 0, right, cv::BORDER_REPLICATE);
    frames.push_back({frame.index, frame.time_s, fitted(cv::Rect({0, 0}, size)).clone()});
  }
  return frames;
}

std::string write_clip(const std::vector<Frame>& frames, int num_frames, double frames_per_s) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("zygoma_tracking_bench_" + std::to_string(getpid()) + ".mp4"))
                               .string();
  const cv::Size size = frames.front().image.size();
  VideoWriter writer(path, size.width, size.height, frames_per_s, {"veryfast", 20, 2});
  const int period = std::max(1, 2 * static_cast<int>(frames.size()) - 2);
  for (int i = 0; i < num_frames; ++i) {
    const int phase = i % period;
    writer.write(frames[static_cast<size_t>(std::min(phase, period - phase))].image,
                 i / frames_per_s);
  }
  writer.finish();
  return path;
}

// Of one pass of the tracker over frames in memory, start included.
double tracking_ms(const std::vector<Frame>& frames) {
  Tracker tracker;
  const double begin = thread_ms();
  for (const Frame& frame : frames) tracker.track(frame);
  return thread_ms() - begin;
}

// Of the frames after the first second: the tracker as it runs on.
double steady_ms_per_frame(const std::vector<Frame>& frames) {
  Tracker tracker;
  const size_t first = std::min<size_t>(30, frames.size() / 2);
  for (size_t i = 0; i < first; ++i) tracker.track(frames[i]);
  const double begin = thread_ms();
  for (size_t i = first; i < frames.size(); ++i) tracker.track(frames[i]);
  return (thread_ms() - begin) / static_cast<double>(frames.size() - first);
}

struct Cost {
  double wall_ms = 0.0;
  double cpu_ms = 0.0;
};

template <typename Work>
Cost cost_of(const Work& work) {
  const Stopwatch watch;
  const double begin = bench::cpu_ms();
  work();
  return {watch.elapsed_ms(), bench::cpu_ms() - begin};
}

void decode(const std::string& video) {
  VideoReader reader(video);
  Frame frame;
  while (reader.read(frame)) {
  }
}

void decode_planes(const std::string& video) {
  VideoReader reader(video);
  Frame frame;
  while (reader.read_planes(frame)) {
  }
}

void bench_tracking(const std::string& video, bench::Table& table) {
  const std::string name = std::filesystem::path(video).stem().string();
  const std::vector<Frame> frames = fitted_frames(video, {640, 480});
  const auto num_frames = static_cast<double>(frames.size());
  std::vector<double> all, steady;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    all.push_back(tracking_ms(frames) / num_frames);
    steady.push_back(steady_ms_per_frame(frames));
  }
  table.line(
      format("%s,640x480,track with start,cpu ms per frame,%.3f", name.c_str(), median(all)));
  table.line(format("%s,640x480,track,cpu ms per frame,%.3f", name.c_str(), median(steady)));
  table.line(
      format("%s,640x480,track,frames/s on one core,%.1f", name.c_str(), 1e3 / median(steady)));
}

void bench_whole_pass(const std::string& video, bench::Table& table) {
  const std::string name = std::filesystem::path(video).stem().string();
  const std::vector<Frame> frames = fitted_frames(video, {1280, 720});
  const int num_frames = static_cast<int>(frames.size());
  const std::string clip = write_clip(frames, num_frames, 30.0);
  std::vector<double> decode_wall, decode_cpu, planes_cpu, pass_cpu, wall_ratio, cpu_ratio;
  SilentObserver silent;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const Cost decoding = cost_of([&] { decode(clip); });
    planes_cpu.push_back(cost_of([&] { decode_planes(clip); }).cpu_ms / num_frames);
    const Cost pass = cost_of([&] { track_video(clip, {}, {}, silent, {}); });
    pass_cpu.push_back(pass.cpu_ms / num_frames);
    decode_wall.push_back(decoding.wall_ms / num_frames);
    decode_cpu.push_back(decoding.cpu_ms / num_frames);
    wall_ratio.push_back(pass.wall_ms / decoding.wall_ms);
    cpu_ratio.push_back(pass.cpu_ms / decoding.cpu_ms);
  }
  std::filesystem::remove(clip);
  table.line(format("%s,1280x720,decode,ms per frame,%.3f", name.c_str(), median(decode_wall)));
  table.line(format("%s,1280x720,decode,cpu ms per frame,%.3f", name.c_str(), median(decode_cpu)));
  table.line(format("%s,1280x720,decode without conversion,cpu ms per frame,%.3f",
                    name.c_str(),
                    median(planes_cpu)));
  table.line(
      format("%s,1280x720,decode and track,cpu ms per frame,%.3f", name.c_str(), median(pass_cpu)));
  table.line(
      format("%s,1280x720,decode and track,times decoding,%.2f", name.c_str(), median(wall_ratio)));
  table.line(format(
      "%s,1280x720,decode and track,times decoding (cpu),%.2f", name.c_str(), median(cpu_ratio)));
}

// Peak of resident memory of this process since it began, MiB.
double peak_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::atof(line.c_str() + 6) / 1024.0;
  }
  return 0.0;
}

// What the process of its own does.
int report_memory(const char* video, const char* seconds) {
  SilentObserver silent;
  const TrackLimits limits{std::atof(seconds), {}};
  const TrackedVideo tracked = track_video(video, {}, {}, silent, {}, limits);
  std::printf("%zu %.1f\n", tracked.contours.size(), peak_mib());
  return 0;
}

std::string output_of(const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += "'" + word + "' ";
  FILE* pipe = popen(line.c_str(), "r");
  char text[128] = {};
  if (pipe == nullptr || std::fgets(text, sizeof text, pipe) == nullptr) text[0] = '\0';
  if (pipe != nullptr) pclose(pipe);
  return text;
}

void bench_memory(const std::string& program, const std::string& video, bench::Table& table) {
  const std::string name = std::filesystem::path(video).stem().string();
  const std::string clip =
      write_clip(fitted_frames(video, {640, 480}), static_cast<int>(kLongClip_s * 25.0), 25.0);
  for (const char* seconds : {"60", "0"}) {
    int num_frames = 0;
    double mib = 0.0;
    std::sscanf(
        output_of({program, "--memory", clip, seconds}).c_str(), "%d %lf", &num_frames, &mib);
    table.line(format("%s,640x480,track %d frames,peak MiB,%.1f", name.c_str(), num_frames, mib));
  }
  std::filesystem::remove(clip);
}

int run(int argc, char** argv) {
  if (argc == 4 && std::strcmp(argv[1], "--memory") == 0) return report_memory(argv[2], argv[3]);
  std::string csv;
  std::vector<std::string> videos;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--csv") == 0 && i + 1 < argc) {
      csv = argv[++i];
    } else {
      videos.emplace_back(argv[i]);
    }
  }
  if (videos.empty()) {
    std::fprintf(stderr, "usage: tracking_bench [--csv RESULT.csv] VIDEO...\n");
    return 2;
  }
  bench::Table table(csv,
                     "tracking_bench; medians of " + std::to_string(kRepeats) +
                         " passes, alternating; cpu is processor time, of one thread at 640x480",
                     "clip,size,what,unit,value");
  cv::setNumThreads(1);
  for (const std::string& video : videos) bench_tracking(video, table);
  for (const std::string& video : videos) bench_whole_pass(video, table);
  bench_memory(std::filesystem::read_symlink("/proc/self/exe").string(), videos.front(), table);
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  try {
    return zygoma::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tracking_bench: %s\n", error.what());
    return 2;
  }
}
