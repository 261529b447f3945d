// The whole run, stage by stage, against two limits measured in the same process: real time (how
// long the clip lasts) and decoding alone (what any reader of the file must pay). Repeats alternate
// the measured things, so that a machine that drifts hits all of them; medians are reported.
//
//   whole_run_bench VIDEO [REPEATS] [RESULT.csv]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "face/generic_head.h"
#include "retarget/measure_response.h"
#include "retarget/retarget.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/track_video.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/silent_observer.h"

namespace zygoma {
namespace {

using bench::median;

struct Row {
  const char* name;
  std::vector<double> ms;
};

double decode_ms(const std::string& video) {
  const Stopwatch watch;
  VideoReader reader(video);
  Frame frame;
  while (reader.read(frame)) {
  }
  return watch.elapsed_ms();
}

int run_bench(const std::string& video, int repeats, const char* csv) {
  const std::string output =
      (std::filesystem::temp_directory_path() / "zygoma_whole_run_bench.mp4").string();
  Row rows[] = {{"decode only", {}},
                {"track", {}},
                {"assemble face", {}},
                {"retarget", {}},
                {"animate", {}},
                {"whole run", {}}};
  SilentObserver silent;
  double clip_s = 0.0;
  std::size_t num_frames = 0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    rows[0].ms.push_back(decode_ms(video));

    const Stopwatch whole;
    const TrackedVideo tracked = track_video(video, {}, {}, silent, {});
    rows[1].ms.push_back(tracked.figures.total_ms);
    clip_s = tracked.contours.back().time_s;
    num_frames = tracked.contours.size();

    const Stopwatch assemble;
    const auto anatomy = std::make_shared<const Anatomy>(make_generic_head());
    Simulator face(anatomy);
    rows[2].ms.push_back(assemble.elapsed_ms());

    const Stopwatch estimate;
    RetargetReport report;
    const FaceResponse response = measure_response(face);
    const ContractionTrack track = retarget(tracked.contours, {response}, {}, report);
    rows[3].ms.push_back(estimate.elapsed_ms());

    const AnimationReport animation = animate_face(
        track, face, anatomy, Performance{video, tracked.contours}, output, {}, silent, {});
    rows[4].ms.push_back(animation.figures.total_ms);
    rows[5].ms.push_back(whole.elapsed_ms());
  }
  std::filesystem::remove(output);

  std::ofstream file;
  if (csv != nullptr) {
    file.open(csv);
    file << "stage,ms_per_frame,share_of_real_time,ratio_to_decoding\n";
  }
  std::printf("%s: %zu frames, %.2f s, %d repeats, medians\n",
              std::filesystem::path(video).filename().c_str(),
              num_frames,
              clip_s,
              repeats);
  std::printf("%-14s %12s %14s %12s\n", "stage", "ms / frame", "of real time", "x decoding");
  for (const Row& row : rows) {
    const double ms = median(row.ms);
    const double per_frame = ms / static_cast<double>(num_frames);
    const double share = ms / (clip_s * 1e3);
    const double ratio = ms / median(rows[0].ms);
    std::printf("%-14s %12.2f %14.2f %12.1f\n", row.name, per_frame, share, ratio);
    if (file.is_open()) {
      char line[160];
      std::snprintf(line, sizeof line, "%s,%.3f,%.4f,%.2f\n", row.name, per_frame, share, ratio);
      file << line;
    }
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: whole_run_bench VIDEO [REPEATS] [RESULT.csv]\n");
    return 2;
  }
  const int repeats = argc > 2 ? std::max(1, std::atoi(argv[2])) : 3;
  try {
    return zygoma::run_bench(argv[1], repeats, argc > 3 ? argv[3] : nullptr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "whole_run_bench: %s\n", error.what());
    return 2;
  }
}
