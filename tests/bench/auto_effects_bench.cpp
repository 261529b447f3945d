// Effects chosen by the scene against everything in every frame.
//
//   auto_effects_bench SCENE.json [RESULT.csv [SURFACE_VERTICES...]]
//
// The scene's motion (samples/two_minutes.json: rest, speech, play of the brows, smiles, a wide
// jaw, 120 s at 30 frames/s) is played with all effects but gravity, once where they are called for
// and once in every frame with all tissue solved for (what --simulate-all gives), frame by frame in
// turn, so that both meet the same load of the machine. CPU time per frame, and how far the two
// surfaces are apart. Speech begins where no other part does, and so on: kParts.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "face/scene.h"
#include "src/io/scene_file.h"
#include "tests/bench/bench_tools.h"

namespace zygoma {
namespace {

struct Part {
  const char* name;
  double begin_s;
  double end_s;
};

constexpr Part kParts[] = {{"rest", 0.0, 8.0},
                           {"speech with pauses", 8.0, 28.9},
                           {"listening", 28.9, 36.0},
                           {"play of the brows", 36.0, 53.7},
                           {"rest", 53.7, 58.0},
                           {"smiles", 58.0, 76.4},
                           {"rest", 76.4, 82.0},
                           {"wide jaw", 82.0, 94.0},
                           {"rest", 94.0, 102.0},
                           {"speech in a smile", 102.0, 110.0},
                           {"rest", 110.0, 116.0},
                           {"startle", 116.0, 1e9},
                           {"everything", 0.0, 1e9}};

struct Frame {
  double time_s = 0.0;
  double chosen_ms = 0.0;
  double all_ms = 0.0;
  bool solved = true;
  bool converged = true;
  double largest_mm = 0.0;
  double sum_mm2 = 0.0;
};

class Player {
 public:
  Player(const std::shared_ptr<const Anatomy>& anatomy, const Scene& scene)
      : face_(make_simulator(scene, anatomy)), state_(face_.rest()) {}

  SettleReport play(const Controls& controls, double step_s, double& ms) {
    const double begin = bench::cpu_ms();
    const SettleReport report =
        step_s == 0.0 ? face_.settle(controls, state_) : face_.advance(controls, step_s, state_);
    ms = bench::cpu_ms() - begin;
    return report;
  }
  const FaceState& state() const { return state_; }

 private:
  Simulator face_;
  FaceState state_;
};

std::vector<Frame> play(const Scene& scene) {
  const auto anatomy =
      std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head));
  const ContractionTrack track = sample_motion(scene.motion, anatomy->muscle_names());
  Scene everything = scene;
  everything.settle.choose_mm = everything.settle.still_mm = 0.0;
  Player chosen(anatomy, scene);
  Player all(anatomy, everything);
  std::vector<Frame> frames;
  for (std::size_t k = 0; k < track.frames.size(); ++k) {
    const Contractions& at = track.frames[k];
    const Controls controls{at.value, at.jaw * anatomy->jaw.full_rad};
    const double step_s = k == 0 ? 0.0 : at.time_s - track.frames[k - 1].time_s;
    Frame frame;
    frame.time_s = at.time_s;
    const SettleReport one = chosen.play(controls, step_s, frame.chosen_ms);
    const SettleReport other = all.play(controls, step_s, frame.all_ms);
    frame.solved = one.solved;
    frame.converged = one.converged && other.converged;
    for (std::size_t v = 0; v < anatomy->surface.positions_mm.size(); ++v) {
      const double off2 =
          (chosen.state().positions_mm[v] - all.state().positions_mm[v]).squaredNorm();
      frame.largest_mm = std::max(frame.largest_mm, std::sqrt(off2));
      frame.sum_mm2 += off2 / static_cast<double>(anatomy->surface.positions_mm.size());
    }
    frames.push_back(frame);
  }
  return frames;
}

std::string row_of(int surface_vertices, const Part& part, const std::vector<Frame>& frames) {
  Frame sum;
  int num = 0;
  int solved = 0;
  int unsettled = 0;
  for (const Frame& frame : frames) {
    if (frame.time_s < part.begin_s || frame.time_s >= part.end_s) continue;
    ++num;
    solved += frame.solved;
    unsettled += !frame.converged;
    sum.chosen_ms += frame.chosen_ms;
    sum.all_ms += frame.all_ms;
    sum.sum_mm2 += frame.sum_mm2;
    sum.largest_mm = std::max(sum.largest_mm, frame.largest_mm);
  }
  if (num == 0) return {};
  return bench::format("%d,%s,%d,%d,%.3f,%.3f,%.2f,%.4f,%.5f,%d",
                       surface_vertices,
                       part.name,
                       num,
                       solved,
                       sum.chosen_ms / num,
                       sum.all_ms / num,
                       sum.all_ms / sum.chosen_ms,
                       sum.largest_mm,
                       std::sqrt(sum.sum_mm2 / num),
                       unsettled);
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  using namespace zygoma;
  if (argc < 2) {
    std::fprintf(stderr, "auto_effects_bench SCENE.json [RESULT.csv [SURFACE_VERTICES...]]\n");
    return 2;
  }
  Scene scene = read_scene(argv[1]);
  scene.head.skin_levels = 0;
  std::vector<int> sizes;
  for (int k = 3; k < argc; ++k) sizes.push_back(std::atoi(argv[k]));
  if (sizes.empty()) sizes.push_back(scene.head.num_surface_vertices);
  bench::Table table(
      argc > 2 ? argv[2] : "",
      bench::format("auto_effects_bench; %s, tolerance %g mm", argv[1], scene.settle.choose_mm),
      "surface_vertices,part,frames,frames_solved,ms_chosen,ms_everything,times_faster,largest_mm,"
      "rms_mm,frames_not_converged");
  for (const int size : sizes) {
    scene.head.num_surface_vertices = size;
    const std::vector<Frame> frames = play(scene);
    for (const Part& part : kParts) {
      const std::string row = row_of(size, part, frames);
      if (!row.empty()) table.line(row);
    }
  }
  return 0;
}
