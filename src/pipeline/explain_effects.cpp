#include "src/pipeline/explain_effects.h"

#include <algorithm>
#include <cstdio>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr int kSameRange = 15;  // frames without the effect that do not end a range

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

void find_ranges(const Simulation& simulation, std::size_t place, EffectStory& story) {
  for (std::size_t k = 0; k < simulation.uses.size(); ++k) {
    const EffectUse& use = simulation.uses[k][place];
    // The first frame is a jump from rest, in which everything acts.
    if (k > 0) story.could_change_mm = std::max(story.could_change_mm, use.could_change_mm);
    if (!use.acts) continue;
    ++story.num_frames;
    const int frame = static_cast<int>(k);
    if (story.frames.empty() || frame - story.frames.back().second > kSameRange) {
      story.frames.emplace_back(frame, frame);
    }
    story.frames.back().second = frame;
  }
}

std::string reason(const Effect& effect, const EffectStory& story, const Explanation& all) {
  if (!story.in_scene) {
    return effect.only_if_asked.empty() ? "not in the scene"
                                        : "not in the scene: " + effect.only_if_asked;
  }
  if (all.tolerance_mm == 0.0) return "the scene has it in every frame";
  if (effect.called_for_when.empty()) return "always there where tissue moves: " + effect.what;
  const bool ever = story.num_frames > 1;
  return (ever ? "" : "never: ") + effect.called_for_when +
         format(ever ? " (up to %.2g mm expected)" : " (at most %.2g mm expected)",
                story.could_change_mm);
}

}  // namespace

Explanation explain_effects(const Scene& scene,
                            const std::shared_ptr<const Anatomy>& anatomy,
                            const ContractionTrack& track,
                            StageObserver& observer,
                            const StopQuestion& stop) {
  Explanation all;
  all.tolerance_mm = scene.settle.choose_mm;
  const auto run = [&](const Scene& variant, const std::string& stage) {
    observer.begin(stage, static_cast<int>(track.frames.size()));
    const auto count = [&](int frame, const FaceState&, const MotionRow&) {
      observer.update(frame + 1);
    };
    Simulation simulation = simulate_scene(variant, anatomy, track, count, stop);
    observer.end();
    all.stopped = all.stopped || simulation.stopped;
    return simulation;
  };
  const Simulation base = run(scene, "as the scene says");
  all.frame_ms = base.frame_ms();
  all.num_frames = static_cast<int>(base.rows.size());
  all.num_solved = static_cast<int>(std::count_if(
      base.rows.begin(), base.rows.end(), [](const MotionRow& row) { return row.settle.solved; }));
  if (all.stopped) return all;
  Scene everything = scene;
  everything.settle.choose_mm = everything.settle.still_mm = 0.0;
  const Simulation full = run(everything, "everything");
  if (all.stopped) return all;
  all.everything_ms = full.frame_ms();
  const Distance off = distance_between(base, full);
  all.largest_mm = off.largest_mm;
  all.rms_mm = off.rms_mm();
  for (std::size_t place = 0; place < all_effects().size(); ++place) {
    const Effect& effect = all_effects()[place];
    EffectStory story;
    story.effect = effect.name;
    Scene without = scene;
    story.in_scene = std::erase_if(without.tissue.effects, [&](const EffectChoice& choice) {
                       return choice.name == effect.name;
                     }) > 0;
    find_ranges(base, place, story);
    story.ms_with = story.ms_without = base.frame_ms();
    if (story.in_scene) {
      const Simulation varied = run(without, "without " + effect.name);
      if (all.stopped) return all;
      story.ms_without = varied.frame_ms();
      const Distance apart = distance_between(base, varied);
      story.largest_mm = apart.largest_mm;
      story.rms_mm = apart.rms_mm();
    }
    story.why = reason(effect, story, all);
    all.stories.push_back(std::move(story));
  }
  return all;
}

std::string explanation_table(const Explanation& all) {
  std::string text = "effect         acts in       costs        changes at most   RMS\n";
  for (const EffectStory& story : all.stories) {
    const double share = all.num_frames > 0 ? 100.0 * story.num_frames / all.num_frames : 0.0;
    text += format("%-14s %5.1f %%  %+8.3f ms  %8.3f mm  %10.4f mm\n",
                   story.effect.c_str(),
                   share,
                   story.ms_with - story.ms_without,
                   story.largest_mm,
                   story.rms_mm);
    text += "               " + story.why + "\n";
    if (story.num_frames > 0 && story.num_frames < all.num_solved) {
      constexpr std::size_t kMost = 12;
      std::vector<std::pair<int, int>> first = story.frames;
      const bool more = first.size() > kMost;
      if (more) first.resize(kMost);
      text += "               frames " + text_of(first) + (more ? " ..." : "") + "\n";
    }
  }
  text += format("%d of %d frames solved, the others would not have moved visibly\n",
                 all.num_solved,
                 all.num_frames);
  text += format(
      "%.3f ms per frame; with everything %.3f ms, from which this differs by %.3f mm at "
      "most, RMS %.4f mm",
      all.frame_ms,
      all.everything_ms,
      all.largest_mm,
      all.rms_mm);
  text += all.tolerance_mm > 0.0 ? format(" (tolerance %g mm)\n", all.tolerance_mm) : "\n";
  return text;
}

}  // namespace zygoma
