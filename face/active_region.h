// Which columns of tissue have to be solved for: those that the controls can move, and those that
// have not come back yet. The rest stays where it is and costs nothing.
//
// How far the controls can move a column is estimated by the response of the tissue at rest,
// sum_m c_m |dx/dc_m|, which is exact for small motions. For the others there is a second look when
// the region has settled: a node that is left out must not feel more force than would move it by
// the tolerance. Columns where it does join, and the region settles again.
#pragma once

#include <vector>

#include "face/control_reach.h"
#include "face/energy.h"
#include "face/solvers/equilibrium.h"
#include "face/state.h"

namespace zygoma {

class ActiveRegion {
 public:
  // `energy` must outlive the region.
  explicit ActiveRegion(FaceEnergy& energy) : energy_(energy) {}

  // Restricts energy and solver to what these controls can move further than still_mm. Keeps the
  // region it has as long as that is not much larger than needed.
  void choose(const std::vector<double>& contraction,
              double jaw_rad,
              double still_mm,
              const FaceState& state,
              EquilibriumSolver& solver);

  // Adds the columns that were wrongly left out of `state`; false if there are none.
  bool grow(double still_mm, const FaceState& state, EquilibriumSolver& solver);

  // Solves for all columns again.
  void release(EquilibriumSolver& solver);

  // Of all columns.
  double moving_share() const;

 private:
  void restrict_all(EquilibriumSolver& solver);

  FaceEnergy& energy_;
  ControlReach reach_;
  std::vector<char> moving_;  // per column; empty = all
};

}  // namespace zygoma
