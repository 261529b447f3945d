// Symmetric matrix of a lattice, as dense blocks between columns of nodes.
//
// All free nodes below one surface vertex form one block row, so the pattern is the graph of the
// surface mesh: one block per column and one per edge. Columns may differ in the number of their
// nodes; unknowns are 3 node + axis. Energy terms add 3 x 3 pieces at offsets looked up once; the
// pattern never changes. Of the blocks of columns only the lower triangle counts.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace zygoma {

struct ColumnMatrix {
  std::vector<std::vector<int>> nodes;    // per column; every free node is in one of them
  std::vector<std::array<int, 2>> edges;  // coupled columns, first < second, sorted
  std::vector<std::size_t> begin;         // of each block in values: columns, edges; and the end
  std::vector<double> values;             // column-major; rows of an edge's block = second

  void reset(std::vector<std::vector<int>> nodes_of_columns,
             std::vector<std::array<int, 2>> coupled) {
    nodes = std::move(nodes_of_columns);
    edges = std::move(coupled);
    begin.assign(1, 0);
    const auto append = [&](int second, int first) {
      begin.push_back(begin.back() + static_cast<std::size_t>(rows(second)) * rows(first));
    };
    for (int c = 0; c < num_columns(); ++c) append(c, c);
    for (const auto& [first, second] : edges) append(second, first);
    values.assign(begin.back(), 0.0);
  }
  void set_zero() { std::fill(values.begin(), values.end(), 0.0); }

  int num_columns() const { return static_cast<int>(nodes.size()); }
  int rows(int column) const { return 3 * static_cast<int>(nodes[column].size()); }
  int num_unknowns() const {
    int sum = 0;
    for (int c = 0; c < num_columns(); ++c) sum += rows(c);
    return sum;
  }

  using Block = Eigen::Map<const Eigen::MatrixXd>;
  Block diagonal(int column) const {
    return {values.data() + begin[column], rows(column), rows(column)};
  }
  Block edge(std::size_t e) const {
    const auto& [first, second] = edges[e];
    return {values.data() + begin[nodes.size() + e], rows(second), rows(first)};
  }
};

}  // namespace zygoma
