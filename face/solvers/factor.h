// Cholesky factorisation of a lattice's Hessian; the one place that knows how it is done.
//
// Multifrontal: the columns of nodes are put into an order that keeps the factor sparse, and those
// eliminated together make one dense front, so that nearly all the work is in dense matrix
// products. The order is found once from the pattern; only numbers are computed anew. One thread,
// fixed order of sums: same bits on every run.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "face/solvers/column_matrix.h"

namespace zygoma {

class Factor {
 public:
  // Symbolic part. Columns that are not active are left out as if their nodes could not move; an
  // empty `active` means all take part.
  explicit Factor(const ColumnMatrix& pattern, const std::vector<char>& active = {});

  // Factors h + shift I. False if that is not positive definite; solve() is then undefined.
  bool compute(const ColumnMatrix& h, double shift);

  // Replaces every right-hand side (a column of x) by the solution. Rows: 3 node + axis; those of
  // columns that are not active become zero.
  void solve(Eigen::Ref<Eigen::MatrixXd> x) const;

  // Numbers in the factor: what one solve has to read.
  std::size_t size() const;

 private:
  struct Piece {  // of the original matrix, into a front
    std::size_t values_begin = 0;
    int row = 0;  // place in the front, row >= column
    int column = 0;
    int num_rows = 0;
    int num_columns = 0;
    bool transposed = false;
  };
  struct Run {  // of rows that stay together
    int from = 0;
    int to = 0;
    int count = 0;
  };
  struct Front {
    int own_begin = 0;  // rows in the elimination order
    int own_rows = 0;
    int rest_rows = 0;           // later rows it touches
    std::vector<Run> rest;       // from its rest to rows in the elimination order
    std::vector<Run> to_parent;  // from its rest to places in the parent
    std::vector<int> children;
    std::vector<Piece> pieces;
    Eigen::MatrixXd panel;   // own rows: L11, below: L21
    Eigen::MatrixXd update;  // what is left for the parent
  };

  void assemble(const ColumnMatrix& h, double shift, Front& front);
  // In elimination order; one right-hand side, and several.
  void solve_one(double* y) const;
  void solve_many(Eigen::Ref<Eigen::MatrixXd> y) const;

  int num_unknowns_ = 0;
  std::vector<int> node_;      // by place in the elimination order
  std::vector<Front> fronts_;  // children before parents
};

}  // namespace zygoma
