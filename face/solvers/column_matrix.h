// Symmetric matrix of a lattice, as dense blocks between columns of nodes.
//
// All free nodes below one surface vertex form one block row, so the pattern is the graph of the
// surface mesh: one block per column and one per edge. Energy terms add 3 x 3 pieces at offsets
// looked up once; the pattern never changes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

namespace zygoma {

struct ColumnMatrix {
  int num_columns = 0;
  int block = 0;                          // rows per column: 3 per free node
  std::vector<std::array<int, 2>> edges;  // first < second; block rows = second
  std::vector<double> values;             // column-major blocks: columns first, then edges

  void reset(int columns, int rows_per_column, const std::vector<std::array<int, 2>>& graph) {
    num_columns = columns;
    block = rows_per_column;
    edges = graph;
    values.assign((columns + edges.size()) * block * block, 0.0);
  }
  void set_zero() { std::fill(values.begin(), values.end(), 0.0); }

  using Block = Eigen::Map<const Eigen::MatrixXd>;
  Block diagonal(int column) const {
    return {&values[static_cast<std::size_t>(column) * block * block], block, block};
  }
  Block edge(std::size_t e) const {
    return {&values[(num_columns + e) * block * block], block, block};
  }
};

}  // namespace zygoma
