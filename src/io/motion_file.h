// motion.csv and effects.csv: what a simulation did, frame by frame, and what each effect costs and
// changes (docs/formats.md).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "face/simulator.h"

namespace zygoma {

struct MotionRow {
  double time_s = 0.0;
  SettleReport settle;
  double largest_mm = 0.0;  // displacement from rest over the surface
  double rms_mm = 0.0;
  double ms = 0.0;  // of processor time
};

void write_motion_csv(const std::string& path, const std::vector<MotionRow>& rows);

struct EffectRow {
  std::string effect;
  bool in_scene = false;
  double ms_with = 0.0;  // per frame, of processor time
  double ms_without = 0.0;
  int not_converged_with = 0;  // frames
  int not_converged_without = 0;
  double largest_mm = 0.0;  // between with and without, over the surface and all frames
  double rms_mm = 0.0;
};

// When an effect of a scene acted, and what for.
struct EffectStory {
  std::string effect;
  bool in_scene = false;
  std::vector<std::pair<int, int>> frames;  // first and last of every range in which it acted
  int num_frames = 0;                       // in all of them together
  double ms_with = 0.0;                     // per frame, of processor time
  double ms_without = 0.0;
  double largest_mm = 0.0;  // between with and without, over the surface and all frames
  double rms_mm = 0.0;
  double could_change_mm = 0.0;  // largest that was expected of it in a frame
  std::string why;
};

void write_effect_stories_csv(const std::string& path, const std::vector<EffectStory>& stories);

// "12-40 55 60-90"
std::string text_of(const std::vector<std::pair<int, int>>& frames);

void write_effects_csv(const std::string& path, const std::vector<EffectRow>& rows);

}  // namespace zygoma
