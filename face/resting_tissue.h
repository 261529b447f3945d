// Tissue that rests while other parts of the face move: it stays where it is, in whatever pose, and
// costs nothing.
//
// Every control has a zone, the columns that it can move further than a share of the tolerance.
// When a motion begins on a face that stood still, only the zones of the muscles that move wake;
// others join with their muscles, and what none of the muscles has moved for a while rests again.
//
// Two measures say when a column that rests has to wake: what the controls have changed since, by
// the reach of each, and the change of the force from its neighbours that move, against its
// stiffness.
#pragma once

#include <vector>

#include "face/control_reach.h"
#include "face/energy.h"
#include "face/solvers/equilibrium.h"

namespace zygoma {

class RestingTissue {
 public:
  // `energy` and `reach` must outlive it.
  RestingTissue(FaceEnergy& energy, const ControlReach& reach, double tolerance_mm);

  // Before a frame: sees which controls move, the jaw last. `at_rest`: the face has stood still,
  // the region may be any.
  void follow(const std::vector<double>& controls,
              double step_s,
              bool at_rest,
              EquilibriumSolver& solver);

  // After a frame: whether some of what moves could rest, which is asked now and then only.
  bool could_shrink();
  // Lets it rest if none of it has far to go; per column.
  void shrink(const std::vector<double>& left_mm, EquilibriumSolver& solver);

  // All tissue moves, with controls that stand there.
  void wake_all(const std::vector<double>& controls, EquilibriumSolver& solver);

  double moving_share() const;

 private:
  std::vector<char> wanted() const;
  void choose(std::vector<char> moving, EquilibriumSolver& solver);
  void measure_drift(const EquilibriumSolver& solver);

  FaceEnergy& energy_;
  const ControlReach& reach_;
  double tolerance_mm_;
  std::vector<std::vector<char>> zone_;  // per control
  std::vector<double> largest_reach_;    // per control
  std::vector<char> moving_;             // per column
  std::vector<double> drift_mm_;         // per column that rests: how wrong its place may be
  std::vector<double> drift_base_mm_;    // the same, when the region was chosen
  std::vector<double> base_controls_;    // of then
  std::vector<Vec3> base_force_;         // of then, on the nodes that rest
  std::vector<double> anchor_;           // of every control, where it was last seen moving
  std::vector<double> still_s_;          // since when
  int frames_to_question_ = 0;
};

}  // namespace zygoma
