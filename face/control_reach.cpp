#include "face/control_reach.h"

#include <algorithm>
#include <limits>

namespace zygoma {

ControlReach find_control_reach(FaceEnergy& energy, EquilibriumSolver& solver) {
  const Lattice& lattice = energy.lattice();
  const std::vector<Vec3>& rest = lattice.rest_mm;
  energy.set_controls(std::vector<double>(energy.muscles().pulls.size(), 0.0), 0.0);
  Factor factor = solver.factor();
  solver.factor_at(rest, factor);
  ControlReach reach;
  Eigen::MatrixXd motion = energy.control_forces(rest, solver.hessian());
  factor.solve(motion);
  reach.mm.assign(motion.cols(), std::vector<double>(lattice.columns.size(), 0.0));
  for (Eigen::Index control = 0; control < motion.cols(); ++control) {
    for (int node = 0; node < lattice.num_free_nodes; ++node) {
      double& most = reach.mm[control][lattice.column_of[node]];
      most = std::max(most, motion.block<3, 1>(3 * node, control).norm());
    }
  }
  Eigen::MatrixXd sag = Eigen::MatrixXd::Zero(motion.rows(), 3);
  for (int node = 0; node < lattice.num_free_nodes; ++node) {
    sag.block<3, 3>(3 * node, 0) = lattice.mass_kg[node] * Eigen::Matrix3d::Identity();
  }
  factor.solve(sag);
  for (int node = 0; node < lattice.num_free_nodes; ++node) {
    reach.sag_mm = std::max(reach.sag_mm, sag.block<3, 3>(3 * node, 0).colwise().norm().maxCoeff());
  }
  reach.stiffness.assign(lattice.columns.size(), std::numeric_limits<double>::infinity());
  for (std::size_t c = 0; c < lattice.columns.size(); ++c) {
    reach.stiffness[c] =
        solver.hessian().free().diagonal(static_cast<int>(c)).diagonal().minCoeff();
  }
  return reach;
}

}  // namespace zygoma
