// The potential energy of the tissue, whose minimum is the face.
//
//   E(x; c, jaw) = sum_k psi_k(l_k)                          springs, equation (1)
//                + sum_j kappa_j/2 |x_j - t_j(c, jaw)|^2     muscles, equations (3) and (4)
//                + the terms of the scene's effects          volume, contact, inertia, ...
//
// Muscles ask fascia nodes to go to t_j, softly: kappa_j = kappa w_j area_j does not depend on the
// contractions, so the face is a smooth function of them. Bone nodes are prescribed: at rest, or
// carried by the mandible. t_j is carried along with the bone below. Around mouth and eyes there is
// no bone below but mucosa that slides over teeth and eyeball: there the lowest nodes follow the
// pull of the muscles as far as `slip` says, and the fascia is held firmly to its target, so that a
// flap moves as a whole however thin it is. Where the surface is cut off, at the neck and behind
// the forehead, real tissue goes on: there all nodes are held, else this edge, which nobody
// looks at, would be the softest place of all and take the solver most of its steps.
//
// Unknowns are the free nodes; vectors run 3 node + axis, free nodes first.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "face/anatomy.h"
#include "face/effect.h"
#include "face/lattice.h"
#include "face/muscle_field.h"
#include "face/spring_term.h"
#include "face/tissue_hessian.h"

namespace zygoma {

struct MuscleOptions {
  double hold_kpa_per_mm = 15.0;  // kappa; below 3 tissue wins over muscles
  double slip_hold_ratio = 10.0;  // how much firmer muscles hold where the floor slips
  double slip_elsewhere = 0.7;    // [0, 1]; 0 = glued to the bone, as in the paper
  double slip_reach_mm = 18.0;    // from lips and lids, where slip has faded to slip_elsewhere
  double rim_hold_ratio = 1.0;    // how firmly tissue that was cut off holds the rest; 0 = not
  void check() const;             // throws InputError naming the value outside its range
};

// What the tissue of a scene is made of and what acts on it.
struct TissueModel {
  LatticeOptions lattice;
  MuscleOptions muscles;
  std::vector<EffectChoice> effects{{"volume", {}}};
};

class FaceEnergy {
 public:
  // `anatomy` must outlive the energy.
  explicit FaceEnergy(const Anatomy& anatomy, const TissueModel& model = {});
  // With a lattice of another making over the anatomy's surface.
  FaceEnergy(const Anatomy& anatomy,
             Lattice lattice,
             const MuscleOptions& muscles,
             const std::vector<EffectChoice>& effects);
  FaceEnergy(const FaceEnergy&) = delete;  // terms refer to the lattice
  FaceEnergy& operator=(const FaceEnergy&) = delete;

  const Lattice& lattice() const { return lattice_; }
  const MuscleField& muscles() const { return muscles_; }
  const Effects& effects() const { return effects_; }
  int num_unknowns() const { return 3 * lattice_.num_free_nodes; }
  int num_nodes() const { return static_cast<int>(lattice_.rest_mm.size()); }

  // Sets muscle targets and the motion of the bone. Contractions outside [0, 1] are allowed here.
  void set_controls(const std::vector<double>& contraction, double jaw_rad);

  // Moves the bone nodes of x to where the controls have them.
  void place_bone(std::vector<Vec3>& x) const;

  // Where the jaw, as set, carries a point of a column.
  Vec3 carried(int node) const;

  // Where the muscles hold a node, and how firmly (mN/mm).
  struct Hold {
    int node = 0;
    double stiffness = 0.0;
    Vec3 target_mm = Vec3::Zero();
  };
  const std::vector<Hold>& holds() const { return holds_; }

  // Only the marked nodes move from now on; the others cost nothing.
  void restrict_to(const std::vector<char>& moving);
  // The same, of the free nodes of the marked columns.
  void restrict_to_columns(const std::vector<char>& moving);

  // Energy; `gradient` gets d(energy)/dx of all nodes. What it says of bone and of nodes that do
  // not move is not complete.
  double evaluate(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const;

  // Exact second derivatives. The matrix must come from make_hessian().
  TissueHessian make_hessian() const;
  void hessian(const std::vector<Vec3>& x, TissueHessian& h) const;
  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const;

  // - d(gradient)/d(control) at x, where the second derivatives are h: one column per muscle, the
  // last one for the jaw, per rad.
  Eigen::MatrixXd control_forces(const std::vector<Vec3>& x, const TissueHessian& h) const;

  // Largest force of the muscles on a node, mN.
  double largest_muscle_force(const std::vector<Vec3>& x) const;

  // Takes an effect away, or brings it back: terms that are away execute nothing. The pattern of
  // the Hessian must have been made while all were there.
  void set_acts(std::size_t part, bool acts);

  // Adds the forces of an effect, away or not, to the gradient.
  void add_effect_gradient(std::size_t part,
                           const std::vector<Vec3>& x,
                           Eigen::VectorXd& gradient) const;

  // A step of time begins or ends, for effects with memory.
  void begin_step(const FaceState& state, double step_s);
  void end_step(FaceState& state);

  struct VolumeReport {
    int inverted = 0;
    double mean_change = 0.0;  // mean |V - V0| / V0
  };
  VolumeReport volumes(const std::vector<Vec3>& x) const;

 private:
  double floor_slip(const Column& column) const {
    return options_.slip_elsewhere +
           (1.0 - options_.slip_elsewhere) * lattice_.below(flap_, column);
  }
  void find_flaps();
  void find_holds();
  void smooth_mandible_weight();

  const Anatomy& anatomy_;
  Lattice lattice_;
  MuscleOptions options_;
  Effects effects_;
  std::vector<std::size_t> num_pieces_;  // of the Hessian, per effect that has ever been away
  SpringTerm springs_;
  MuscleField muscles_;
  std::vector<Hold> holds_;              // of fascia, and of all above it at the rim or where thin
  std::vector<int> holds_begin_;         // per column, and one more: its range in holds_
  std::vector<Vec3> pull_mm_;            // per column: sum_i c_i s_i b_ij m_ij
  std::vector<double> flap_;             // per vertex, 1 on lips and lids, fading to 0
  std::vector<double> mandible_weight_;  // per vertex
  double jaw_rad_ = 0.0;
  Eigen::Isometry3d jaw_motion_ = Eigen::Isometry3d::Identity();
};

}  // namespace zygoma
