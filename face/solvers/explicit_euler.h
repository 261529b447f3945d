// The explicit procedure of the paper, for a face that moves in time:
//
//   m a = f - q - gamma v,      v := v + dt a,      x := x + dt v
//
// f: springs, holds and outer forces on a node; q: gradient of any further energy. The springs pull
// a stretched pair together (the print has the opposite sign). The order above (semi-implicit) is
// stable for
//
//   dt < min over nodes of (sqrt(gamma^2 + 4 m K) - gamma) / K,     K = 2 sum of beta + holds
//
// since the stiffness matrix is at most diag(K) (Gershgorin; beta is the largest stiffness of a
// spring). The order as printed, x by the old v, needs dt <= gamma / K and dt < 2 m / gamma:
// without damping it is never stable. Steps keep to 0.9 of the bound, and a larger dt is refused
// unless forced. A watchdog looks at the energy now and then: if it is not finite, or far beyond
// what was there and what outer forces have done, the last good state comes back and dt is halved.
//
// The state is in float around the middle of the lattice: this is an animation device. It is good
// to some 1e-5 mm, and slow to settle with true masses; relax() takes masses in proportion to
// stiffness and damping tuned on the way, and gets to a rough equilibrium as fast as anything
// explicit.
#pragma once

#include <functional>
#include <vector>

#include "face/solvers/lattice_kernels.h"

namespace zygoma {

struct ExplicitNodes {
  std::vector<double> mass_kg;           // > 0, one per node
  std::vector<double> damping_kg_per_s;  // gamma >= 0, one per node
  std::vector<char> fixed;               // one per node; 1 = prescribed
};

struct ExplicitOptions {
  double safety = 0.9;         // share of the bound that a step takes, (0, 1]
  double dt_s = 0.0;           // 0 = by itself; larger than the bound is refused ...
  bool force_dt = false;       // ... unless forced
  bool literal_order = false;  // x by the old v, as printed
  int watch_every = 32;        // steps between two looks of the watchdog, >= 1
};

struct ExplicitReport {
  int substeps = 0;  // without those that were undone
  double dt_s = 0.0;
  double bound_s = 0.0;
  int restores = 0;      // times the watchdog brought back a good state
  bool gave_up = false;  // it did so too often; x is the last good state
  double largest_speed_mm_per_s = 0.0;
  double residual_mn = 0.0;  // largest force on a free node, damping aside
  double energy = 0.0;       // kinetic and potential, without outer forces; mN mm
};

struct RelaxReport {
  bool converged = false;
  int steps = 0;
  int restores = 0;
  double residual_mn = 0.0;
};

class ExplicitEuler {
 public:
  // Returns an energy and adds its gradient.
  using Energy = std::function<double(const std::vector<Vec3>& x, std::vector<Vec3>& gradient)>;

  // Starts at rest_mm, at which the springs have their lengths as given. Throws InputError on
  // masses, damping or dt outside their range.
  ExplicitEuler(const std::vector<Spring>& springs,
                const std::vector<Vec3>& rest_mm,
                const ExplicitNodes& nodes,
                const ExplicitOptions& options = {});

  // A spring of length zero from the node to a target, as muscles pull.
  void set_hold(int node, double stiffness, const Vec3& target_mm);
  void set_outer_force(int node, const Vec3& force_mn);
  // Any further energy, whose stiffness at a node is no more than given. Called every step.
  void set_energy(Energy energy, std::vector<double> stiffness_per_node);
  // Moves a node, keeping its velocity.
  void place(int node, const Vec3& x_mm);
  void set_velocity(int node, const Vec3& v_mm_per_s);

  std::vector<Vec3> positions() const;
  std::vector<Vec3> velocities() const;

  // The largest stable step, for the order as chosen.
  double bound_s() const;

  ExplicitReport advance(double time_s);

  // To where no free node feels more than tolerance_mn; velocities are lost.
  RelaxReport relax(double tolerance_mn, int max_steps);

 private:
  // Four floats in a register.
  typedef float Four __attribute__((vector_size(16)));
  struct State {
    std::vector<LatticeNode<float>> nodes;
    std::vector<Four> velocity;
  };
  // Few nodes have these, so they do not burden the others.
  struct Hold {
    int node;
    Four target;
    float stiffness;
  };
  struct OuterForce {
    int node;
    Four force;
    Four from;  // where the node was when advance() began, for the work done
  };
  struct Energies {
    double kinetic = 0.0, potential = 0.0, outer_work = 0.0;
    bool sane(const Energies& start, double least) const;
  };
  struct Relaxation;

  Four centred(const Vec3& x) const;
  std::vector<double> node_stiffness(bool as_stretched_now) const;
  double add_forces(bool want_energy);
  void integrate(float dt);
  Energies energies(double spring_energy) const;
  double residual_mn() const;  // of the gradient that stands in the nodes
  void clear_gradient();
  void renew_masses(double heavier, Relaxation& r) const;
  void relax_step(Relaxation& r);

  std::vector<Spring> springs_;
  ExplicitOptions options_;
  SpringSet<float> set_;
  Vec3 centre_mm_ = Vec3::Zero();
  State state_;
  std::vector<double> mass_;
  std::vector<double> damping_;
  std::vector<Four> inertia_;  // 1/m, 1/m, 1/m, gamma/m; 0 if fixed
  std::vector<Hold> holds_;
  std::vector<OuterForce> outer_;
  double energy_scale_ = 0.0;
  double dt_limit_s_ = 0.0;  // by the watchdog; 0 = none

  Energy energy_;
  std::vector<double> energy_stiffness_;
  std::vector<Vec3> x_mm_, energy_gradient_;  // workspace of energy_
};

}  // namespace zygoma
