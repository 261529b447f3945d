// Cholesky factorisation of a lattice's Hessian; the one place that knows how it is done.
//
// Multifrontal: the columns of nodes are put into an order that keeps the factor sparse, and those
// eliminated together make one dense front, so that nearly all the work is in dense matrix products
// (face/solvers/dense_kernels.h). The order is found once from the pattern; only numbers are
// computed anew. One thread, fixed order of sums: same bits on every run of one machine.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <new>
#include <vector>

#include "face/solvers/column_matrix.h"
#include "face/solvers/dense_kernels.h"

namespace zygoma {

// Begins at a cache line.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class U>
  explicit CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t n) {
    return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t(64)));
  }
  void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t(64)); }
  bool operator==(const CacheLineAllocator&) const { return true; }
};
template <class T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

class Factor {
 public:
  // Symbolic part, which finds an order for all columns.
  explicit Factor(const ColumnMatrix& pattern, const DenseKernels& kernels = dense_kernels());
  // Of these columns only, in this order; the others are left out as if their nodes could not move.
  // What is left of a good order is good enough for a part, and costs no search.
  Factor(const ColumnMatrix& pattern,
         const std::vector<int>& columns,
         const DenseKernels& kernels = dense_kernels());

  // Factors h + shift I. False if that is not positive definite; solve() is then undefined.
  bool compute(const ColumnMatrix& h, double shift);

  // Replaces every right-hand side (a column of x) by the solution. Rows: 3 node + axis; those of
  // columns that take no part become zero.
  void solve(Eigen::Ref<Eigen::MatrixXd> x) const;

  // The same in single precision, at half the time: reading the factor is what takes it. Relative
  // error 1e-6 for forces spread over the face, 1e-5 for those that change from node to node; meant
  // for preconditioning.
  void solve_roughly(Eigen::Ref<Eigen::VectorXd> x) const;
  // And the same of a vector that holds what takes part and nothing else, as nodes() has it.
  void solve_roughly_in_order(Eigen::Ref<Eigen::VectorXd> y) const;

  // Columns and nodes that take part, in the order of elimination.
  const std::vector<int>& columns() const { return columns_; }
  const std::vector<int>& nodes() const { return node_; }

  // Numbers in the factor: what one solve has to read.
  std::size_t size() const { return panels_.size(); }

 private:
  struct Piece {  // of the original matrix, into a front
    std::size_t values_begin = 0;
    int row = 0;  // place in the front, row >= column
    int column = 0;
    int num_rows = 0;
    int num_columns = 0;
    bool transposed = false;
  };
  struct Front {
    int own_begin = 0;  // rows in the elimination order
    int own = 0;
    int height = 0;              // own rows and the later ones it touches, the rest
    std::vector<Run> rest;       // from rows of the front to rows in the elimination order
    std::vector<Run> to_parent;  // from rows of the front to rows of the parent
    std::vector<int> children;
    std::vector<Piece> pieces;
    std::size_t panels_begin = 0;
    // Fronts wait for their parents on two stacks, by their depth in the tree: so parents can be
    // put up while their children lie on top of the other stack.
    int stack = 0;
    std::size_t stack_begin = 0;
  };

  enum class Order { kGiven, kWanted };

  void make_fronts(const ColumnMatrix& pattern, const std::vector<int>& columns, Order order);
  void place_storage();
  double* assemble(const ColumnMatrix& h, double shift, const Front& front);
  template <class T>
  void solve_one(const AlignedVector<T>& panels, Eigen::Ref<Eigen::VectorXd> x) const;
  template <class T>
  void solve_in_order(const AlignedVector<T>& panels, AlignedVector<T>& y) const;
  void solve_some(Eigen::Ref<Eigen::MatrixXd> x) const;

  const DenseKernels* kernels_;
  int num_unknowns_ = 0;
  int largest_height_ = 0;
  std::vector<int> columns_;
  std::vector<int> node_;      // by place in the elimination order
  std::vector<Front> fronts_;  // children before parents
  AlignedVector<double> panels_;
  AlignedVector<float> rough_panels_;
  std::array<AlignedVector<double>, 2> stacks_;
  AlignedVector<double> work_;
};

}  // namespace zygoma
