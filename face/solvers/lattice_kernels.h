// Energy and gradient of springs and prisms, many at a time: the loops that every solver of the
// tissue spends its time in, apart from factoring.
//
// The law is the one of face/tissue.h and face/prism.h without its branches: along a band of half
// width d, with t = max((past + d) / 2d, 0), u = min(t, 1) and p = t - u,
//
//   force = 2d (u^3 - u^4 / 2 + p),      energy = 4d^2 (u^4 / 4 - u^5 / 10 + (p^2 + p) / 2)
//
// holds below, inside and above the band. Lengths and volumes at rest are computed by the kernels
// themselves, so that forces at rest are exactly zero. A set sums in one fixed order in one thread:
// results depend on the machine's width of SIMD and on nothing else.
//
// A set may hold any part of a lattice; it is cheap to make (some 40 ns per spring).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <new>
#include <vector>

#include "face/lattice.h"
#include "face/solvers/lattice_rows.h"

namespace zygoma {

// The widest kernels this machine can run, and all that it can run, the widest last.
const LatticeKernels& lattice_kernels();
std::vector<const LatticeKernels*> all_lattice_kernels();

// Position and gradient of a node, side by side: one cache line serves both.
template <typename Real>
struct alignas(8 * sizeof(Real)) LatticeNode {
  Real x = 0, y = 0, z = 0, unused = 0;
  Real dx = 0, dy = 0, dz = 0, unused_too = 0;
};
// Positions x and gradient 0.
template <typename Real>
void reset_nodes(const std::vector<Vec3>& x, std::vector<LatticeNode<Real>>& nodes) {
  nodes.resize(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    nodes[k] = {
        static_cast<Real>(x[k].x()), static_cast<Real>(x[k].y()), static_cast<Real>(x[k].z())};
  }
}

// The nodes that a set touches, where it touches some of all: the others are not copied.
class TouchedNodes {
 public:
  // One mark per node.
  void choose(const std::vector<char>& touched) {
    touched_.clear();
    for (std::size_t k = 0; k < touched.size(); ++k) {
      if (touched[k]) touched_.push_back(static_cast<int>(k));
    }
    nodes_.assign(touched.size(), {});
  }
  // At positions x with gradient 0.
  LatticeNode<double>* at(const std::vector<Vec3>& x) {
    for (const int k : touched_) nodes_[k] = {x[k].x(), x[k].y(), x[k].z()};
    return nodes_.data();
  }
  // To a vector of all nodes, 3 node + axis.
  void add_gradients(Eigen::VectorXd& gradient) const {
    for (const int k : touched_) {
      gradient[3 * k] += nodes_[k].dx;
      gradient[3 * k + 1] += nodes_[k].dy;
      gradient[3 * k + 2] += nodes_[k].dz;
    }
  }

 private:
  std::vector<int> touched_;
  std::vector<LatticeNode<double>> nodes_;
};

// Memory that a register of any width can be loaded from.
template <typename T>
struct SimdAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  SimdAllocator() = default;
  template <typename U>
  explicit SimdAllocator(const SimdAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  bool operator==(const SimdAllocator&) const { return true; }
};
template <typename T>
using SimdVector = std::vector<T, SimdAllocator<T>>;

// In double for solvers; in float for explicit integration, where lengths are good to some 1e-7 of
// themselves, and forces to as much of stiffness times length.
template <typename Real>
class SpringSet {
 public:
  SpringSet() = default;
  // `x` are positions of all nodes at which the lengths of the springs are known as given: a spring
  // with rest_mm equal to its length there has exactly no force there. Laws keep to tissue.h, and
  // slackening <= alpha.
  SpringSet(const std::vector<Spring>& springs,
            const std::vector<Vec3>& x,
            const LatticeKernels& kernels = lattice_kernels());

  // Energy; adds its gradient.
  Real energy_and_gradient(LatticeNode<Real>* nodes) const;
  void add_gradient(LatticeNode<Real>* nodes) const;

  // Lengths at the nodes, as the kernels see them: that of spring k is by_lane[lane_of(k)].
  void find_lengths(const LatticeNode<Real>* nodes, SimdVector<Real>& by_lane) const;
  std::size_t lane_of(std::size_t spring) const {
    return slots_[spring].row * lanes_ + slots_[spring].lane;
  }
  // Gives a spring whose law has no bands another stiffness alpha and length at rest (> 0).
  void set_spring(std::size_t spring, double alpha, double rest_mm);

 private:
  struct Slot {
    std::size_t row = 0;
    int lane = 0;
  };
  void find_slots(const std::vector<Spring>& springs, std::size_t num_nodes);
  void fill_shapes(const std::vector<Spring>& springs);
  void fill_numbers(const std::vector<Spring>& springs, const std::vector<Vec3>& x);
  SpringRows<Real> rows() const;
  std::size_t num_rows() const { return group_begin_.back(); }

  const LatticeKernels* kernels_ = &lattice_kernels();
  int lanes_ = 1;
  std::vector<Slot> slots_;  // of the springs in the order given
  std::vector<int> group_begin_{0};
  std::vector<int> owner_;
  std::vector<int> neighbor_;
  SimdVector<Real> numbers_;
  SimdVector<Real> shape_;
  int shape_step_ = 0;
};

// Volume and barrier energy of prisms, K/2 V0 (J - 1)^2 + ratio K V0 max(start - J, 0)^3 with
// J = V / V0.
class PrismSet {
 public:
  struct Barrier {
    double start = 0.3;
    double ratio = 3.0;  // 0 = none
  };
  PrismSet() = default;
  // Positions x serve as in SpringSet.
  PrismSet(const std::vector<Prism>& prisms,
           const std::vector<Vec3>& x,
           const Barrier& barrier,
           const LatticeKernels& kernels = lattice_kernels());

  // Energy; adds its gradient.
  double energy_and_gradient(LatticeNode<double>* nodes) const;

 private:
  PrismRows rows() const;

  const LatticeKernels* kernels_ = &lattice_kernels();
  Barrier barrier_;
  std::vector<int> node_;
  SimdVector<double> numbers_;
};

}  // namespace zygoma
