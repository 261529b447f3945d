// Cholesky factorisation of a lattice's Hessian; the one place that knows how it is done.
//
// Multifrontal: the columns are ordered by nested dissection of the surface (halve it across its
// longest axis, number the seam last), and every piece is eliminated as one dense front, so that
// nearly all the work is in dense matrix products. The order is found once from the rest positions;
// only numbers are computed anew. One thread, fixed order of sums: same bits on every run.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "face/geometry.h"
#include "face/solvers/column_matrix.h"

namespace zygoma {

class Factor {
 public:
  // Symbolic part. `positions_mm` per column guide the dissection; `pattern` supplies the graph.
  Factor(const std::vector<Vec3>& positions_mm, const ColumnMatrix& pattern);

  // Factors h + shift I. False if that is not positive definite; solve() is then undefined.
  bool compute(const ColumnMatrix& h, double shift);

  // Replaces every right-hand side (a column of x) by the solution. Rows in node order:
  // 3 (layer * num_columns + column) + axis.
  void solve(Eigen::Ref<Eigen::MatrixXd> x) const;

  // Doubles in the factor: what one solve has to read.
  std::size_t size() const;

 private:
  struct Piece {  // of the original matrix, into a front
    std::size_t values_begin = 0;
    int row = 0;  // block position in the front, row >= column
    int column = 0;
    bool transposed = false;
  };
  struct Front {
    int parent = -1;
    int own_begin = 0;  // columns by position in the elimination order
    int own_end = 0;
    std::vector<int> boundary;         // positions of later columns it touches, ascending
    std::vector<int> place_in_parent;  // block position of each boundary column in the parent
    std::vector<int> children;
    std::vector<Piece> pieces;
    Eigen::MatrixXd panel;   // own rows: L11, below: L21
    Eigen::MatrixXd update;  // what is left for the parent
  };

  void dissect(std::vector<int> columns, const std::vector<Vec3>& positions_mm, int parent);
  void find_boundaries();
  void place_pieces(const ColumnMatrix& pattern);
  void assemble(const ColumnMatrix& h, double shift, Front& front);
  // In elimination order, rows block_ * position; one right-hand side, and several.
  void solve_one(double* y) const;
  void solve_many(Eigen::Ref<Eigen::MatrixXd> y) const;

  int block_ = 0;
  int num_columns_ = 0;
  std::vector<std::vector<int>> neighbors_;
  std::vector<int> order_;     // column at each position
  std::vector<int> position_;  // of each column
  std::vector<Front> fronts_;  // children before parents
};

}  // namespace zygoma
