// A performer whose contractions are known: an identity of its own, a schedule of expressions, head
// sway, lighting and camera noise, rendered to frames with the true contours.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "face/contractions.h"
#include "face/generic_head.h"
#include "tracker/contour_set.h"
#include "tracker/frame.h"

namespace zygoma {

struct PerformerOptions {
  std::uint32_t seed = 1;  // identity, schedule, sway, noise: everything random comes from it
  std::string schedule = "mixed";  // mixed | surprise | smile | speech | neutral
  double duration_s = 6.0;         // (0, 600]
  double frames_per_s = 30.0;      // [5, 120]
  int width_px = 640;
  int height_px = 360;
  double noise_grey_levels = 2.0;  // standard deviation of the camera noise, [0, 40]
  double sway = 1.0;               // 0: the head is still
  int num_threads = 2;
  int num_surface_vertices = 700;  // of the performer's own lattice, [300, 4000]; few: fast, coarse

  void check() const;
};

class Performer {
 public:
  explicit Performer(const PerformerOptions& options);
  ~Performer();

  int num_frames() const;
  const std::vector<std::string>& muscles() const;

  // Renders the next frame; false after the last one. All outputs belong to the same instant.
  bool next(Frame& frame, Contractions& truth, ContourSet& true_contours);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
