// Runs a scene frame by frame: settled under the pose of its first frame, then advanced through
// time. And once more for each effect, with it and without, to say what it costs and changes.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "face/scene.h"
#include "src/base/stop.h"
#include "src/io/motion_file.h"
#include "src/pipeline/stage_observer.h"

namespace zygoma {

struct Simulation {
  std::vector<MotionRow> rows;
  std::vector<std::vector<Vec3>> surfaces_mm;  // per frame
  // Per frame, the effects of the scene by place in all_effects(); nothing acts in frames that were
  // not solved.
  std::vector<std::vector<EffectUse>> uses;
  bool stopped = false;  // with what is done so far

  double frame_ms() const;  // mean
  double worst_residual() const;
  int frames_not_converged() const;
  int most_inverted_elements() const;
  double largest_volume_change() const;
};

// Takes a frame: its number, the state of the face in it, and how it was reached.
using FrameTaker = std::function<void(int, const FaceState&, const MotionRow&)>;

// How far points are from where they were: the largest, and the sum of squares.
struct Distance {
  double largest_mm = 0.0;
  double sum_mm2 = 0.0;
  double count = 0.0;

  void add(const std::vector<Vec3>& a, const std::vector<Vec3>& b);
  double rms_mm() const;
};

// Over all frames.
Distance distance_between(const Simulation& a, const Simulation& b);

// `face` is made for the scene and new; `track` is the scene's motion (face/motion.h) for the
// muscles of its anatomy.
Simulation simulate_scene(Simulator& face,
                          const ContractionTrack& track,
                          const FrameTaker& take,
                          const StopQuestion& stop);
Simulation simulate_scene(const Scene& scene,
                          const std::shared_ptr<const Anatomy>& anatomy,
                          const ContractionTrack& track,
                          const FrameTaker& take,
                          const StopQuestion& stop);

// `base` is the scene as it stands. An effect that it does not have is added with its usual values.
// A stop leaves the rows done so far.
std::vector<EffectRow> compare_effects(const Scene& scene,
                                       const std::shared_ptr<const Anatomy>& anatomy,
                                       const ContractionTrack& track,
                                       const Simulation& base,
                                       StageObserver& observer,
                                       const StopQuestion& stop);

// Plain text.
std::string effect_table(const std::vector<EffectRow>& rows);

}  // namespace zygoma
