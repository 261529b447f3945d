// Why a scene was simulated the way it was: for every effect when it acted, what it cost and
// changed, and why; and the whole against everything in every frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "src/pipeline/simulate_scene.h"

namespace zygoma {

struct Explanation {
  std::vector<EffectStory> stories;  // as all_effects()
  double frame_ms = 0.0;             // mean
  double everything_ms = 0.0;        // the same, with every effect of the scene in every frame
  int num_frames = 0;
  int num_solved = 0;       // the others would not have moved visibly
  double largest_mm = 0.0;  // from everything, over the surface and all frames
  double rms_mm = 0.0;
  double tolerance_mm = 0.0;  // 0: the scene leaves no choice
  bool stopped = false;       // with what is known so far
};

// Runs the scene, then with everything, then once more for each of its effects without it.
Explanation explain_effects(const Scene& scene,
                            const std::shared_ptr<const Anatomy>& anatomy,
                            const ContractionTrack& track,
                            StageObserver& observer,
                            const StopQuestion& stop);

// Plain text.
std::string explanation_table(const Explanation& explanation);

}  // namespace zygoma
