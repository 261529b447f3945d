// Levels of quality of the physical face: a point each on the front of what accuracy costs in time
// (`zygoma tradeoff` measures that front on the machine at hand, docs/accuracy-and-time.md).
#pragma once

#include <string>
#include <vector>

#include "face/generic_head.h"
#include "face/simulator.h"

namespace zygoma {

struct FaceQuality {
  std::string name;
  int surface_vertices = 300;  // of the lattice, about
  bool bi_layer = false;       // two layers of tissue instead of three
  double relative_residual = 1e-4;
  // Of the skin against the reference, as measured with a smile, raised brows and an opening jaw
  // (docs/results/tradeoff.csv); 0 for the reference.
  double expected_rms_mm = 0.0;

  void apply(HeadOptions& head, TissueModel& tissue, SettleOptions& settle) const;
};

// From the quickest to the most accurate. Four have names that users know: draft, standard, fine,
// reference; those in between are for budgets.
const std::vector<FaceQuality>& face_qualities();

// Throws InputError naming the choices if there is none of that name.
const FaceQuality& face_quality(const std::string& name);

}  // namespace zygoma
