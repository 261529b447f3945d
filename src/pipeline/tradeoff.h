// What accuracy costs in time: a motion is simulated with many choices of layers, nodes, tolerance
// and solver, and each is held against one converged reference.
//
// The error is that of the skin people see: at points of the reference's skin on the face, and
// along the nine curves, the displacement there against that of the nearest point of the other skin
// at rest, over all frames. The reference is the finest choice there is, never a coarser one of
// itself.
#pragma once

#include <string>
#include <vector>

#include "face/contractions.h"
#include "face/quality.h"
#include "face/scene.h"
#include "src/base/stop.h"
#include "src/pipeline/stage_observer.h"

namespace zygoma {

struct TissueChoice {
  std::string name;  // one of face_qualities(), or empty
  FaceQuality quality;
  Solver solver = Solver::kImplicit;
};

struct TradeoffRow {
  TissueChoice choice;
  int num_nodes = 0;
  double frame_ms = 0.0;  // of processor time, mean over the motion
  double rms_mm = 0.0;    // against the reference, over points and frames
  double largest_mm = 0.0;
  int frames_not_converged = 0;
  int most_inverted_elements = 0;
  bool on_front = false;  // nothing else is both quicker and closer
};

struct Tradeoff {
  TissueChoice reference;
  double reference_ms = 0.0;
  int reference_nodes = 0;
  std::vector<TradeoffRow> rows;  // by time
  bool stopped = false;           // with what is done so far
};

// Smile, raised brows and an opening jaw, one after the other and together, in 2 s.
Motion tradeoff_motion();

// Layers, nodes and tolerances that are worth comparing, and explicit steps.
std::vector<TissueChoice> tissue_choices();
TissueChoice tissue_reference();  // finer than any of them

// `scene` gives head, effects and motion; its resolution, layers and solver are varied.
Tradeoff measure_tradeoff(const Scene& scene,
                          const std::vector<TissueChoice>& choices,
                          const TissueChoice& reference,
                          StageObserver& observer,
                          const StopQuestion& stop);

// tradeoff.csv, and a plot of error over time with the front.
void write_tradeoff_csv(const std::string& path, const Tradeoff& tradeoff);
void write_tradeoff_plot(const std::string& path, const Tradeoff& tradeoff);

}  // namespace zygoma
