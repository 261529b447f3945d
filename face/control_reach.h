// How far each control moves each column of tissue, to first order around rest: the columns of
// dx/dc = - H^-1 d(grad E)/dc, one per muscle and a last one for the jaw.
#pragma once

#include <vector>

#include "face/energy.h"
#include "face/solvers/equilibrium.h"

namespace zygoma {

struct ControlReach {
  // Per control and column, mm per unit of the control (of the jaw: per rad), of the node that goes
  // furthest.
  std::vector<std::vector<double>> mm;
  std::vector<double> stiffness;  // per column: smallest of its nodes, mN/mm
  double sag_mm = 0.0;            // largest motion under an acceleration of 1 mm/s^2
};

// Leaves the energy with all controls at zero.
ControlReach find_control_reach(FaceEnergy& energy, EquilibriumSolver& solver);

}  // namespace zygoma
