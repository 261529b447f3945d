// The tissue of tradeoff.h: a motion with many choices of layers, nodes, tolerance and solver, and
// with effects.
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
#include "src/pipeline/tradeoff.h"

namespace zygoma {

struct TissueChoice {
  std::string name;  // one of face_qualities(), or empty
  FaceQuality quality;
  Solver solver = Solver::kImplicit;
  std::string without;  // an effect of the scene that is left out, or empty
};

// Smile, raised brows and an opening jaw, one after the other and together, in 2 s.
Motion tradeoff_motion();

// Layers, nodes and tolerances that are worth comparing, explicit steps, and the usual choice
// without each of the scene's effects.
std::vector<TissueChoice> tissue_choices(const Scene& scene);
TissueChoice tissue_reference();  // finer than any of them

// `scene` gives head, effects and motion; its resolution, layers and solver are varied.
TradeoffStage measure_tissue(const Scene& scene,
                             const std::vector<TissueChoice>& choices,
                             const TissueChoice& reference,
                             StageObserver& observer,
                             const StopQuestion& stop);

}  // namespace zygoma
