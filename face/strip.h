// A tensile test of the tissue: a flat strip of all its layers, clamped at both ends, pulled at one
// of them (paper, section 2 and figure 1). What comes out is the material that the springs add up
// to: the biphasic curve of slow stretch, and with viscosity stress that relaxes at held strain,
// strain that creeps under held load, and loops under cyclic stretch.
//
// Where all springs have a slow branch of the same ratio r and relaxation time tau
// (face/effects/viscosity.cpp), a lattice of whatever shape is in small strain one standard linear
// solid of that r and tau: all of its forces are those of the springs alone times the same function
// of time. With the modulus E of the strip at rest,
//
//   relaxation  sigma(t) = E eps (1 + r exp(-t / tau))
//   creep       eps(t)   = sigma / E (1 - r / (1 + r) exp(-t / ((1 + r) tau)))
//   cycles      eps(t)   = eps_m (1 - cos w t), from rest:
//               sigma(t) = E eps(t) + E r eps_m w tau / (1 + (w tau)^2)
//                          (sin w t - w tau cos w t + w tau exp(-t / tau))
//
// Volume preservation has no slow branch and blurs this; so does every strain that is not small.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/energy.h"
#include "face/lattice.h"
#include "face/solvers/equilibrium.h"
#include "face/state.h"

namespace zygoma {

struct StripOptions {
  double length_mm = 40.0;  // x
  double width_mm = 10.0;   // y
  double depth_mm = 6.0;    // z, of all layers
  int cells_along = 12;     // [2, 200]
  int cells_across = 3;     // [1, 50]
  LatticeOptions tissue;    // as prisms, whatever its topology
  void check() const;       // throws InputError naming the value outside its range
};

struct Strip {
  Anatomy anatomy;  // the part of the surface between the clamps
  Lattice lattice;  // the clamped nodes are its bone
  std::vector<int> pulled;
  double length_mm = 0.0;
  double area_mm2 = 0.0;  // of the cross section
};

Strip make_strip(const StripOptions& options = {});

struct StripPoint {
  double time_s = 0.0;
  double strain = 0.0;
  double stress_kpa = 0.0;  // force over the cross section at rest
  bool converged = false;
};

class TensileTest {
 public:
  TensileTest(Strip strip, const std::vector<EffectChoice>& effects);
  TensileTest(const TensileTest&) = delete;  // the energy refers to the strip
  TensileTest& operator=(const TensileTest&) = delete;

  // The end goes to a strain while step_s pass; 0 = without regard to time, as slowly as it takes,
  // which also forgets what was before.
  StripPoint hold(double strain, double step_s = 0.0);
  // The end goes to where it bears a load.
  StripPoint load(double stress_kpa, double step_s = 0.0);

  // Small-strain modulus of the strip at rest.
  double modulus_kpa();

 private:
  void begin(double step_s);
  StripPoint end(double step_s, double stress_kpa, bool converged);
  double stress_at(double strain, bool& converged);

  Strip strip_;
  FaceEnergy energy_;
  EquilibriumSolver solver_;
  FaceState state_;
  double strain_ = 0.0;
  double slope_kpa_ = 0.0;    // of the stress, as last seen
  double last_step_s_ = 0.0;  // that the solver has seen
  Eigen::VectorXd gradient_;
};

struct StandardLinearSolid {
  double modulus_kpa = 0.0;
  double ratio = 0.0;
  double relaxation_s = 0.0;

  double relaxing_stress(double strain, double time_s) const;
  double creeping_strain(double stress_kpa, double time_s) const;
  double cycling_stress(double mean_strain, double period_s, double time_s) const;
};

// The four experiments. What jumps at time 0 does so in a step far below relaxation_s, so that
// the first point is the response at once.
std::vector<StripPoint> stretch_slowly(TensileTest& test, double highest_strain, int num_steps);
std::vector<StripPoint> relax(TensileTest& test, double strain, double duration_s, double step_s);
std::vector<StripPoint> creep(TensileTest& test,
                              double stress_kpa,
                              double duration_s,
                              double step_s);
// From rest between strain 0 and 2 mean_strain.
std::vector<StripPoint> cycle(
    TensileTest& test, double mean_strain, double period_s, int num_cycles, int steps_per_cycle);

}  // namespace zygoma
