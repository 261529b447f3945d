// The potential energy of the tissue, whose minimum is the face.
//
//   E(x; c, jaw) = sum_k psi_k(l_k)                          biphasic springs, equation (1)
//                + sum_e K/(2 V0) (V_e - V0)^2               volume preservation, equation (2)
//                + sum_e 3 K V0 (J0 - V_e/V0)^3, V_e/V0 < J0 barrier: springs cannot see inversion
//                + sum_j kappa_j/2 |x_j - t_j(c, jaw)|^2     muscles, equations (3) and (4)
//
// The print gives the volume term the sign of a force but the place of a gradient; here everything
// is the gradient of one energy, and the force on a node is minus that gradient.
//
// Muscles ask fascia nodes to go to t_j, softly: kappa_j = kappa w_j area_j does not depend on the
// contractions, so the face is a smooth function of them. Bone nodes are prescribed: at rest, or
// carried by the mandible. t_j is carried along with the bone below. Around mouth and eyes there is
// no bone below but mucosa that slides over teeth and eyeball: there the lowest nodes follow the
// pull of the muscles as far as `slip` says, and the fascia is held firmly to its target, so that a
// flap moves as a whole however thin it is.
//
// Unknowns are the free nodes, all but the bone; vectors run 3 node + axis.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "face/anatomy.h"
#include "face/lattice.h"
#include "face/muscle_field.h"
#include "face/solvers/column_matrix.h"

namespace zygoma {

struct EnergyOptions {
  double muscle_hold_kpa_per_mm = 15.0;  // kappa; below 3 tissue wins over muscles
  double barrier_start = 0.3;            // J0, share of the rest volume
  double barrier_ratio = 3.0;            // against the bulk modulus
  double slip_hold_ratio = 10.0;         // how much firmer muscles hold where the floor slips
  double slip_elsewhere = 0.7;           // [0, 1]; 0 = glued to the bone
  double slip_reach_mm = 18.0;           // from lips and lids, where slip has faded to 0
};

class FaceEnergy {
 public:
  // `anatomy` must outlive the energy.
  FaceEnergy(const Anatomy& anatomy, Lattice lattice, const EnergyOptions& options = {});

  const Lattice& lattice() const { return lattice_; }
  const MuscleField& muscles() const { return muscles_; }
  int num_unknowns() const { return 3 * lattice_.num_free_nodes(); }

  // Sets muscle targets and the motion of the bone. Contractions outside [0, 1] are allowed here.
  void set_controls(const std::vector<double>& contraction, double jaw_rad);

  // Moves the bone nodes of x to where the controls have them.
  void place_bone(std::vector<Vec3>& x) const;

  // Where the jaw, as set, carries a point of a column.
  Vec3 carried(int node) const;

  // Energy; `gradient` gets d(energy)/d(free nodes).
  double evaluate(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const;

  // Exact second derivatives by the free nodes. The matrix must come from make_pattern().
  ColumnMatrix make_pattern() const;
  void hessian(const std::vector<Vec3>& x, ColumnMatrix& h) const;

  // Exact second derivatives times a motion of all nodes, bone included; rows of the free nodes.
  Eigen::VectorXd hessian_times(const std::vector<Vec3>& x, const std::vector<Vec3>& motion) const;

  // - d(gradient)/d(control) at x: one column per muscle, the last one for the jaw, per rad.
  Eigen::MatrixXd control_forces(const std::vector<Vec3>& x) const;

  // Largest force of the muscles on a node under the controls as set.
  double largest_muscle_force() const;

  struct VolumeReport {
    int inverted = 0;
    double mean_change = 0.0;  // mean |V - V0| / V0
  };
  VolumeReport volumes(const std::vector<Vec3>& x) const;

 private:
  struct Hold {  // of one node: of the fascia, and of all above it where the tissue is thin
    int node = 0;
    double stiffness = 0.0;
    Vec3 target_mm = Vec3::Zero();
  };
  // Where the 3x3 pieces of a spring and of a prism go in a ColumnMatrix; -1 = bone, no unknown.
  struct SpringSlots {
    int ii = -1, jj = -1, ij = -1;
  };
  struct PrismSlots {
    int diagonal[6];
    int pair[15];
    bool second_is_row[15];
  };
  struct Jet {  // derivatives of the energy of one prism by its volume
    double energy = 0.0, first = 0.0, second = 0.0;
  };

  double floor_slip(int column) const {
    return options_.slip_elsewhere + (1.0 - options_.slip_elsewhere) * flap_[column];
  }
  void find_flaps();
  void find_holds();
  void smooth_mandible_weight();
  Jet prism_jet(const Prism& prism, double volume) const;
  int slot(int row_node, int column_node, bool& first_is_row) const;
  void find_slots();

  const Anatomy& anatomy_;
  Lattice lattice_;
  EnergyOptions options_;
  MuscleField muscles_;
  std::vector<Hold> holds_;
  std::vector<int> holds_begin_;         // per column, and one more: its range in holds_
  std::vector<Vec3> pull_mm_;            // per column: sum_i c_i s_i b_ij m_ij
  std::vector<double> flap_;             // per column, 1 on lips and lids, fading to 0
  std::vector<double> mandible_weight_;  // per column
  std::vector<SpringSlots> spring_slots_;
  std::vector<PrismSlots> prism_slots_;
  double jaw_rad_ = 0.0;
  Eigen::Isometry3d jaw_motion_ = Eigen::Isometry3d::Identity();
};

}  // namespace zygoma
