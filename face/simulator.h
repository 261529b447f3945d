// Drives the lattice face: contractions in, motion of the tissue out (paper, section 4: the muscle
// displacements are applied and the other nodes travel to a new equilibrium).
//
// settle() goes to equilibrium and knows no time. advance() lets a frame's time pass: with effects
// that have a memory (inertia, viscosity) it takes an implicit Euler step, without them it settles,
// and where a scene asks for the explicit procedure of the paper it takes as many explicit steps as
// are stable. All of them work on one energy (energy.h).
#pragma once

#include <memory>
#include <vector>

#include "face/anatomy.h"
#include "face/contractions.h"
#include "face/effect_chooser.h"
#include "face/energy.h"
#include "face/state.h"

namespace zygoma {

// What drives the tissue: one contraction in [0, 1] per muscle of the anatomy, and the jaw opening.
struct Controls {
  std::vector<double> contraction;
  double jaw_rad = 0.0;
  bool operator==(const Controls&) const = default;
};

// How advance() lets time pass.
enum class Solver { kImplicit, kExplicit };

struct SettleOptions {
  Solver solver = Solver::kImplicit;
  double relative_residual = 1e-4;  // stop when the largest force is below this share of the load
  int max_iterations = 150;
  // Where the face settles, columns of tissue that the controls cannot move further than this are
  // not solved for. 0 = all are, always.
  double still_mm = 0.0;
  // As time passes, effects, tissue and frames that change less than this are left out, as far as
  // can be told, and so are the steps of a solve that is this near to its end, by a tenth: the
  // difference to everything is meant to stay below. 0 = nothing is left out.
  double choose_mm = 0.0;
  static constexpr double kUsualChooseMm = 0.1;
  static constexpr double kMostChooseMm = 10.0;
  void check() const;  // throws InputError naming the value outside its range
};

struct SettleReport {
  bool converged = false;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      // largest nodal force left, over the load: the largest force of a
                              // muscle or the bone on the tissue
  int inverted_elements = 0;  // elements with negative volume in the result
  double mean_volume_change = 0.0;  // mean |V - V0| / V0
  double moving_share = 1.0;        // of the columns, those solved for
  bool solved = true;               // false: nothing would have moved visibly, nothing did
  // Of explicit steps: how many, the longest that is stable, and how often the watchdog had to
  // bring back a good state. Converged means that it did not give up; what moves has a residual.
  int substeps = 0;
  double stable_step_s = 0.0;
  int restores = 0;
};

struct Sensitivity {
  // d(surface position)/d(control): one column per muscle in mm, a last one for the jaw in mm per
  // rad; rows 3 v + axis over the surface vertices.
  Eigen::MatrixXd mm;
  // The state is no strict minimum (buckling, or no equilibrium): the Hessian was shifted until it
  // was positive definite, and the derivatives are too small.
  bool damped = false;
};

class Simulator {
 public:
  explicit Simulator(std::shared_ptr<const Anatomy> anatomy,
                     const TissueModel& tissue = {},
                     const SettleOptions& options = {});
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  const Anatomy& anatomy() const;
  const Lattice& lattice() const;
  FaceState rest() const;

  // Moves `state` to the equilibrium under the controls, warm from where it is. A heap (one
  // element in a hundred inside out) goes to the equilibrium of lower energy: the one it falls
  // into, or the one on the path from rest. Same bits for the same state and controls history.
  SettleReport settle(const Controls& controls, FaceState& state);

  // Lets step_s pass while the controls go to `controls`.
  SettleReport advance(const Controls& controls, double step_s, FaceState& state);

  // The effects of the scene, and what is known of each from the last frame; by place.
  const std::vector<Effects::Part>& effects() const;
  std::vector<EffectUse> effect_uses() const;

  // How the surface follows the controls around an equilibrium, from the exact Hessian there.
  Sensitivity surface_sensitivity(const Controls& controls, const FaceState& state);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Positions of the visible skin in a state (Anatomy::skin, same order).
void embed_skin(const Anatomy& anatomy, const FaceState& state, std::vector<Vec3>& skin_mm);

}  // namespace zygoma
