// The face under the explicit procedure of the paper: springs and muscles in single precision, the
// terms of effects as a further force (face/solvers/explicit_euler.h).
//
// Explicit steps have inertia of their own; of the effect of that name they take mass and damping.
#pragma once

#include "face/energy.h"
#include "face/solvers/explicit_euler.h"

namespace zygoma {

class ExplicitFace {
 public:
  // `energy` must outlive it, and have no inertia among its terms.
  ExplicitFace(FaceEnergy& energy, double mass_factor, double damping_per_s);

  // Lets step_s pass while bone and muscles go evenly from where they were to where the energy's
  // controls have them.
  ExplicitReport advance(double step_s, FaceState& state);

 private:
  void take(const FaceState& state);

  FaceEnergy& energy_;
  ExplicitEuler solver_;
  std::vector<Vec3> hold_target_mm_;  // at the end of the last step
  Eigen::VectorXd gradient_;
};

}  // namespace zygoma
