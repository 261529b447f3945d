#include "src/pipeline/simulate_scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "src/pipeline/animate_face.h"
#include "src/pipeline/stage_figures.h"

namespace zygoma {
namespace {

template <typename Value>
auto largest(const std::vector<MotionRow>& rows, const Value& value) {
  decltype(value(rows.front())) most{};
  for (const MotionRow& row : rows) most = std::max(most, value(row));
  return most;
}

// By place in all_effects(); what the scene does not have never acts.
std::vector<EffectUse> uses_in(const Simulator& face, bool solved) {
  std::vector<EffectUse> uses(all_effects().size(), EffectUse{false, 0.0});
  const std::vector<EffectUse> known = face.effect_uses();
  for (std::size_t k = 0; k < known.size(); ++k) {
    EffectUse& use = uses[face.effects()[k].effect - all_effects().data()];
    use = known[k];
    use.acts = use.acts && solved;
  }
  return uses;
}

Scene toggled(const Scene& scene, const std::string& effect, bool& was_there) {
  Scene other = scene;
  const auto removed =
      std::erase_if(other.tissue.effects, [&](const EffectChoice& c) { return c.name == effect; });
  was_there = removed > 0;
  if (!was_there) other.tissue.effects.push_back({effect, {}});
  return other;
}

}  // namespace

void Distance::add(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  assert(a.size() == b.size());
  for (std::size_t v = 0; v < a.size(); ++v) {
    const double off2 = (a[v] - b[v]).squaredNorm();
    largest_mm = std::max(largest_mm, std::sqrt(off2));
    sum_mm2 += off2;
  }
  count += static_cast<double>(a.size());
}

double Distance::rms_mm() const { return count > 0.0 ? std::sqrt(sum_mm2 / count) : 0.0; }

Distance distance_between(const Simulation& a, const Simulation& b) {
  Distance apart;
  for (std::size_t k = 0; k < std::min(a.surfaces_mm.size(), b.surfaces_mm.size()); ++k) {
    apart.add(a.surfaces_mm[k], b.surfaces_mm[k]);
  }
  return apart;
}

double Simulation::frame_ms() const {
  double sum = 0.0;
  for (const MotionRow& row : rows) sum += row.ms;
  return rows.empty() ? 0.0 : sum / static_cast<double>(rows.size());
}

double Simulation::worst_residual() const {
  return largest(rows, [](const MotionRow& row) { return row.settle.residual; });
}

int Simulation::frames_not_converged() const {
  return static_cast<int>(std::count_if(
      rows.begin(), rows.end(), [](const MotionRow& row) { return !row.settle.converged; }));
}

int Simulation::most_inverted_elements() const {
  return largest(rows, [](const MotionRow& row) { return row.settle.inverted_elements; });
}

double Simulation::largest_volume_change() const {
  return largest(rows, [](const MotionRow& row) { return row.settle.mean_volume_change; });
}

Simulation simulate_scene(Simulator& face,
                          const ContractionTrack& track,
                          const FrameTaker& take,
                          const StopQuestion& stop) {
  const Anatomy& anatomy = face.anatomy();
  const std::vector<Controls> controls = controls_for(track, anatomy);
  const std::size_t num_vertices = anatomy.surface.positions_mm.size();
  FaceState state = face.rest();
  Simulation simulation;
  for (std::size_t k = 0; k < controls.size() && !simulation.stopped; ++k) {
    MotionRow row;
    row.time_s = track.frames[k].time_s;
    const double begin_ms = thread_ms();
    if (k == 0) {
      row.settle = face.settle(controls[k], state);
    } else {
      row.settle = face.advance(controls[k], row.time_s - track.frames[k - 1].time_s, state);
    }
    row.ms = thread_ms() - begin_ms;
    simulation.uses.push_back(uses_in(face, row.settle.solved));
    simulation.surfaces_mm.emplace_back(state.positions_mm.begin(),
                                        state.positions_mm.begin() + num_vertices);
    Distance moved;
    moved.add(simulation.surfaces_mm.back(), anatomy.surface.positions_mm);
    row.largest_mm = moved.largest_mm;
    row.rms_mm = moved.rms_mm();
    simulation.rows.push_back(row);
    if (take) take(static_cast<int>(k), state, row);
    simulation.stopped = stop && stop();
  }
  return simulation;
}

Simulation simulate_scene(const Scene& scene,
                          const std::shared_ptr<const Anatomy>& anatomy,
                          const ContractionTrack& track,
                          const FrameTaker& take,
                          const StopQuestion& stop) {
  Simulator face = make_simulator(scene, anatomy);
  return simulate_scene(face, track, take, stop);
}

std::vector<EffectRow> compare_effects(const Scene& scene,
                                       const std::shared_ptr<const Anatomy>& anatomy,
                                       const ContractionTrack& track,
                                       const Simulation& base,
                                       StageObserver& observer,
                                       const StopQuestion& stop) {
  std::vector<EffectRow> rows;
  for (const Effect& effect : all_effects()) {
    EffectRow row;
    row.effect = effect.name;
    const Scene other = toggled(scene, effect.name, row.in_scene);
    observer.begin((row.in_scene ? "without " : "with ") + effect.name,
                   static_cast<int>(track.frames.size()));
    const auto count = [&](int frame, const FaceState&, const MotionRow&) {
      observer.update(frame + 1);
    };
    const Simulation varied = simulate_scene(other, anatomy, track, count, stop);
    observer.end();
    if (varied.stopped) break;
    const Simulation& with = row.in_scene ? base : varied;
    const Simulation& without = row.in_scene ? varied : base;
    row.ms_with = with.frame_ms();
    row.ms_without = without.frame_ms();
    row.not_converged_with = with.frames_not_converged();
    row.not_converged_without = without.frames_not_converged();
    const Distance apart = distance_between(with, without);
    row.largest_mm = apart.largest_mm;
    row.rms_mm = apart.rms_mm();
    rows.push_back(row);
  }
  return rows;
}

std::string effect_table(const std::vector<EffectRow>& rows) {
  std::string text =
      "effect          in scene   ms with  ms without   moves by at most   RMS   not converged\n";
  for (const EffectRow& row : rows) {
    char line[160];
    std::snprintf(line,
                  sizeof line,
                  "%-16s%-8s %9.2f %11.2f %15.3f mm %6.3f mm %5d | %d\n",
                  row.effect.c_str(),
                  row.in_scene ? "yes" : "no",
                  row.ms_with,
                  row.ms_without,
                  row.largest_mm,
                  row.rms_mm,
                  row.not_converged_with,
                  row.not_converged_without);
    text += line;
  }
  return text;
}

}  // namespace zygoma
