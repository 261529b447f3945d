// One term of the potential energy of the tissue, as a value with first and second derivatives.
//
// Everything that acts on the tissue is such a term: springs, muscles, and every effect that a
// scene asks for. All solvers see only their sum, so a term is written once and serves explicit
// steps, implicit steps, equilibrium and sensitivities alike. The force on a node is minus the
// gradient.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "face/geometry.h"
#include "face/state.h"

namespace zygoma {

// Where second derivatives go: into a matrix, into a product, or into its pattern.
class HessianSink {
 public:
  virtual ~HessianSink() = default;
  // Adds d2(energy) / d(x_a) d(x_b). For a != b the transposed piece for (b, a) goes without
  // saying.
  virtual void add(int a, int b, const Eigen::Matrix3d& piece) = 0;
  // That many pieces are left out that would come now.
  virtual void skip(std::size_t /*num_pieces*/) {}

  // Pieces among nodes that do not move may be left out. Null: all move.
  void look_at(const std::vector<char>* moving_nodes) { moving_nodes_ = moving_nodes; }
  bool looks_at(int a, int b) const {
    return moving_nodes_ == nullptr || (*moving_nodes_)[a] != 0 || (*moving_nodes_)[b] != 0;
  }

 private:
  const std::vector<char>* moving_nodes_ = nullptr;
};

class EnergyTerm {
 public:
  virtual ~EnergyTerm() = default;

  // Energy (uJ) at positions x of all nodes; adds d(energy)/d(x), in mN, to gradient[3 node +
  // axis].
  virtual double add_gradient(const std::vector<Vec3>& x_mm, Eigen::VectorXd& gradient) const = 0;

  // The same pairs of nodes in the same order at every call, whatever x is: their places in the
  // matrix are looked up once.
  virtual void add_hessian(const std::vector<Vec3>& x_mm, HessianSink& sink) const = 0;

  // Only the marked nodes move from now on: parts that touch none of them may be left out. Back to
  // everything when all are marked.
  virtual void restrict_to(const std::vector<char>& /*moving*/) {}

  // The mandible stands at this opening now.
  virtual void follow_jaw(double /*jaw_rad*/) {}

  // Adds - d(gradient)/d(jaw_rad) at fixed positions, in mN per rad.
  virtual void add_jaw_force(const std::vector<Vec3>& /*x_mm*/,
                             Eigen::Ref<Eigen::VectorXd> /*forces*/) const {}
};

// A part of an effect that looks back: it lives in steps of time, and what it remembers is in
// FaceState, so that a state can be saved, copied and replayed. Between steps, and when the face is
// settled without regard to time, it has no energy.
class MemoryTerm {
 public:
  virtual ~MemoryTerm() = default;
  virtual void begin_step(const FaceState& state, double step_s) = 0;
  // `state` has the positions at the end of the step.
  virtual void end_step(FaceState& state) = 0;
};

}  // namespace zygoma
