// Which effects act in a frame, when a scene leaves that to the program.
//
// The currency is mm: how far an effect could move the tissue in this frame, against the tolerance.
// Every effect says in its own file how to tell (Effect::could_change_mm):
//
//   by the motion   inertia and viscosity, from how fast the controls are about to move the tissue.
//                   They come before they are needed.
//   by its forces   contact: the forces f that it would put on the tissue as it stands without it,
//                   as the motion |H^-1 f|; exactly zero as long as nothing touches. Where they
//                   come out too large, the frame is done again with the effect.
//
// An effect that acts is asked for its forces in either case. It goes when they have been worth
// half of what makes it come for a while, so that nothing flickers and what goes is too small to be
// seen. Effects that say neither (volume, anisotropy, gravity) are always there.
#pragma once

#include <vector>

#include "face/effect.h"
#include "face/energy.h"
#include "face/solvers/equilibrium.h"

namespace zygoma {

// An effect in a frame.
struct EffectUse {
  bool acts = true;
  double could_change_mm = 0.0;  // as last told; of those that are always there 0
};

class EffectChooser {
 public:
  // `energy` must outlive the chooser. All effects act.
  EffectChooser(FaceEnergy& energy, double tolerance_mm);

  // By place in energy.effects().parts().
  const std::vector<EffectUse>& uses() const { return uses_; }

  void let_all_act();
  bool all_act() const;
  // Of the effects that are told by their forces, those that act.
  int num_contacts() const;

  // Before a frame: what the motion calls for comes.
  void expect(const ExpectedMotion& motion);

  // After a frame, before its step of time ends. False if an effect was missing so badly that the
  // frame has to be done again; it is there now.
  bool accept(const std::vector<Vec3>& x, double step_s, const EquilibriumSolver& solver);

  // After the step of time: what has been of no use for long enough goes, and forgets.
  void dismiss(FaceState& state);

  bool looks_back() const { return !energy_.effects().memory().empty(); }

 private:
  double force_as_motion(std::size_t part,
                         const std::vector<Vec3>& x,
                         const EquilibriumSolver& solver);
  void come(std::size_t part);

  struct Calm {
    double expected_mm = 0.0;
    double calm_s = 0.0;
    int frames_to_question = 0;
  };

  FaceEnergy& energy_;
  double tolerance_mm_;
  std::vector<EffectUse> uses_;
  std::vector<Calm> calm_;
  Eigen::VectorXd force_;  // workspace
};

}  // namespace zygoma
