// What every effect costs and changes, and that an effect a scene does not have costs nothing.
//
//   effects_bench [RESULT.csv]
//   effects_bench --evaluate SCENE TIMES     what is counted: evaluations of one scene's energy
//
// The scene is a smile with opening jaw on the generic head. For every effect the same frames are
// simulated with and without it: CPU time per frame (median of alternating repeats), instructions
// of one evaluation of the energy, and how far the surface ends up elsewhere. Instructions are
// counted by valgrind, where it is installed, on this program as a child; that does not depend on
// the machine's load. The first row holds the mechanism of effects against the bare sum of
// springs and muscles written out by hand.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "face/generic_head.h"
#include "face/simulator.h"
#include "tests/bench/bench_tools.h"

namespace zygoma {
namespace {

constexpr int kFrames = 40;
constexpr int kRepeats = 5;
constexpr double kFrameS = 1.0 / 60.0;

using bench::cpu_ms;
using bench::median;

TissueModel scene_with(const std::vector<std::string>& effects) {
  TissueModel scene;
  scene.effects.clear();
  for (const std::string& name : effects) {
    EffectChoice choice{name, {}};
    scene.effects.push_back(choice);
  }
  return scene;
}

Controls smile(const Anatomy& anatomy, int frame) {
  const double share = std::min(1.0, frame / (0.6 * kFrames));
  Controls controls{std::vector<double>(anatomy.muscles.size(), 0.0),
                    0.25 * std::sin(M_PI * frame / kFrames)};
  for (std::size_t m = 0; m < anatomy.muscles.size(); ++m) {
    if (anatomy.muscles[m].name.starts_with("zygomaticus_major")) {
      controls.contraction[m] = 0.7 * share;
    }
    if (anatomy.muscles[m].name.starts_with("occipitofrontalis")) {
      controls.contraction[m] = 0.7 * share;
    }
  }
  return controls;
}

struct Played {
  double ms_per_frame = 0.0;
  std::vector<std::vector<Vec3>> surface;
  int unsettled = 0;
};

Played play(const std::shared_ptr<const Anatomy>& anatomy, const TissueModel& scene) {
  Simulator face(anatomy, scene);
  FaceState state = face.rest();
  Played played;
  for (int f = 1; f <= kFrames; ++f) {
    const double begin = cpu_ms();
    played.unsettled += !face.advance(smile(*anatomy, f), kFrameS, state).converged;
    played.ms_per_frame += (cpu_ms() - begin) / kFrames;
    played.surface.emplace_back(
        state.positions_mm.begin(),
        state.positions_mm.begin() + static_cast<long>(anatomy->surface.positions_mm.size()));
  }
  return played;
}

// Evaluates the energy at rest; `scene` is an effect beside volume, "none", or "bare": springs and
// muscles summed as if effects had never been thought of.
double evaluate(const std::string& scene, int times) {
  const Anatomy anatomy =
      make_generic_head({}, {.num_surface_vertices = 300, .skin_levels = 0, .albedo_size_px = 64});
  const bool plain = scene == "bare" || scene == "none";
  const FaceEnergy energy(anatomy, plain ? scene_with({}) : scene_with({scene}));
  const Lattice& lattice = energy.lattice();
  const SpringTerm springs(lattice);
  Eigen::VectorXd gradient;
  double sum = 0.0;
  for (int k = 0; k < times; ++k) {
    if (scene != "bare") {
      sum += energy.evaluate(lattice.rest_mm, gradient);
      continue;
    }
    gradient.setZero(3 * energy.num_nodes());
    sum += springs.add_gradient(lattice.rest_mm, gradient);
    for (const FaceEnergy::Hold& hold : energy.holds()) {
      const Vec3 off = lattice.rest_mm[hold.node] - hold.target_mm;
      sum += 0.5 * hold.stiffness * off.squaredNorm();
      gradient.segment<3>(3 * hold.node) += hold.stiffness * off;
    }
  }
  return sum;
}

// Of one evaluation; empty without valgrind.
std::string instructions(const std::string& program, const std::string& scene) {
  const auto collected = [&](int times) {
    const std::string command = "valgrind --tool=callgrind --callgrind-out-file=/dev/null '" +
                                program + "' --evaluate " + scene + " " + std::to_string(times) +
                                " 2>&1";
    FILE* pipe = popen(command.c_str(), "r");
    long long count = -1;
    char line[512];
    while (pipe && std::fgets(line, sizeof line, pipe)) {
      const char* at = std::strstr(line, "Collected : ");
      if (at) count = std::atoll(at + 12);
    }
    if (pipe) pclose(pipe);
    return count;
  };
  const long long few = collected(2);
  const long long many = collected(22);
  return few < 0 || many < 0 ? "" : std::to_string((many - few) / 20);
}

std::string compare(const std::shared_ptr<const Anatomy>& anatomy,
                    const std::string& program,
                    const std::string& name) {
  const bool usual = name == "volume";
  const TissueModel with = scene_with(usual ? std::vector<std::string>{"volume"}
                                            : std::vector<std::string>{"volume", name});
  const TissueModel without =
      scene_with(usual ? std::vector<std::string>{} : std::vector<std::string>{"volume"});
  std::vector<double> ms_with;
  std::vector<double> ms_without;
  Played one;
  Played other;
  for (int r = 0; r < kRepeats; ++r) {
    one = play(anatomy, with);
    other = play(anatomy, without);
    ms_with.push_back(one.ms_per_frame);
    ms_without.push_back(other.ms_per_frame);
  }
  double largest = 0.0;
  double sum2 = 0.0;
  std::size_t count = 0;
  for (int f = 0; f < kFrames; ++f) {
    for (std::size_t v = 0; v < one.surface[f].size(); ++v) {
      const double d2 = (one.surface[f][v] - other.surface[f][v]).squaredNorm();
      largest = std::max(largest, std::sqrt(d2));
      sum2 += d2;
      ++count;
    }
  }
  std::ostringstream row;
  row << name << ',' << median(ms_without) << ',' << median(ms_with) << ','
      << instructions(program, name) << ',' << largest << ','
      << std::sqrt(sum2 / static_cast<double>(count)) << ',' << one.unsettled << '\n';
  return row.str();
}

int run_bench(const std::string& program, const char* csv) {
  const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 500, .skin_levels = 0, .albedo_size_px = 64}));
  std::string table =
      "effect,ms_per_frame_without,ms_per_frame_with,instructions_per_evaluation,"
      "largest_change_mm,rms_change_mm,unsettled_frames\n";
  table += "(springs and muscles written out),,," + instructions(program, "bare") + ",,,\n";
  table += "(no effect in the scene),,," + instructions(program, "none") + ",,,\n";
  for (const Effect& effect : all_effects()) table += compare(anatomy, program, effect.name);
  std::printf("%s", table.c_str());
  if (csv) {
    std::ofstream out(csv);
    out << "# effects_bench; medians of " << kRepeats << "\n" << table;
    if (!out) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  if (argc == 4 && std::string(argv[1]) == "--evaluate") {
    return std::isfinite(zygoma::evaluate(argv[2], std::atoi(argv[3]))) ? 0 : 1;
  }
  return zygoma::run_bench(argv[0], argc > 1 ? argv[1] : nullptr);
}
