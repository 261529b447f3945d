#include "face/solvers/factor.h"

#include <algorithm>
#include <cassert>

#include "face/solvers/dense_kernels.h"
#include "face/solvers/elimination.h"

namespace zygoma {

using Eigen::MatrixXd;

Factor::Factor(const ColumnMatrix& pattern, const std::vector<char>& active)
    : num_unknowns_(pattern.num_unknowns()) {
  assert(active.empty() || static_cast<int>(active.size()) == pattern.num_columns());
  // Columns that take part get numbers of their own.
  std::vector<int> part(pattern.num_columns(), -1);
  std::vector<int> column;
  std::vector<int> weights;
  for (int c = 0; c < pattern.num_columns(); ++c) {
    if (pattern.rows(c) == 0 || (!active.empty() && !active[c])) continue;
    part[c] = static_cast<int>(column.size());
    column.push_back(c);
    weights.push_back(pattern.rows(c));
  }
  std::vector<std::vector<int>> neighbors(column.size());
  for (const auto& [first, second] : pattern.edges) {
    if (part[first] < 0 || part[second] < 0) continue;
    neighbors[part[first]].push_back(part[second]);
    neighbors[part[second]].push_back(part[first]);
  }
  const std::vector<FrontColumns> plan = plan_elimination(neighbors, weights);

  std::vector<int> row(column.size());  // of each column in the elimination order
  std::vector<int> front_of(column.size());
  fronts_.resize(plan.size());
  int next = 0;
  for (std::size_t f = 0; f < plan.size(); ++f) {
    Front& front = fronts_[f];
    front.own_begin = next;
    for (const int v : plan[f].own) {
      row[v] = next;
      front_of[v] = static_cast<int>(f);
      next += weights[v];
      const std::vector<int>& nodes = pattern.nodes[column[v]];
      node_.insert(node_.end(), nodes.begin(), nodes.end());
    }
    front.own_rows = next - front.own_begin;
    for (const int v : plan[f].rest) front.rest_rows += weights[v];
  }

  // Where a column stands in a front.
  const auto place_in = [&](int f, int v) {
    if (front_of[v] == f) return row[v] - fronts_[f].own_begin;
    int place = fronts_[f].own_rows;
    for (const int u : plan[f].rest) {
      if (u == v) return place;
      place += weights[u];
    }
    assert(false);
    return -1;
  };
  const auto append = [](std::vector<Run>& runs, Run run) {
    if (!runs.empty() && runs.back().from + runs.back().count == run.from &&
        runs.back().to + runs.back().count == run.to) {
      runs.back().count += run.count;
    } else {
      runs.push_back(run);
    }
  };
  for (std::size_t f = 0; f < plan.size(); ++f) {
    Front& front = fronts_[f];
    const int parent = plan[f].parent;
    int from = 0;
    for (const int v : plan[f].rest) {
      append(front.rest, {from, row[v], weights[v]});
      append(front.to_parent, {from, place_in(parent, v), weights[v]});
      from += weights[v];
    }
    front.panel.resize(front.own_rows + front.rest_rows, front.own_rows);
    front.update.resize(front.rest_rows, front.rest_rows);
    if (parent >= 0) fronts_[parent].children.push_back(static_cast<int>(f));
  }

  const auto place_piece = [&](std::size_t values_begin, int v, int u) {
    const bool transposed = row[v] < row[u];  // the block's rows are those of v
    if (transposed) std::swap(v, u);
    const int f = front_of[u];
    fronts_[f].pieces.push_back(
        {values_begin, place_in(f, v), place_in(f, u), weights[v], weights[u], transposed});
  };
  for (std::size_t v = 0; v < column.size(); ++v) {
    const int part_v = static_cast<int>(v);
    place_piece(pattern.begin[column[v]], part_v, part_v);
  }
  for (std::size_t e = 0; e < pattern.edges.size(); ++e) {
    const auto& [first, second] = pattern.edges[e];
    if (part[first] < 0 || part[second] < 0) continue;
    place_piece(pattern.begin[pattern.num_columns() + e], part[second], part[first]);
  }
}

void Factor::assemble(const ColumnMatrix& h, double shift, Front& front) {
  front.panel.setZero();
  front.update.setZero();
  for (const Piece& p : front.pieces) {
    auto target = front.panel.block(p.row, p.column, p.num_rows, p.num_columns);
    const double* values = h.values.data() + p.values_begin;
    if (p.transposed) {
      target = Eigen::Map<const MatrixXd>(values, p.num_columns, p.num_rows).transpose();
    } else {
      target = Eigen::Map<const MatrixXd>(values, p.num_rows, p.num_columns);
    }
  }
  if (shift != 0.0) front.panel.diagonal().array() += shift;
  for (const int c : front.children) {
    const Front& child = fronts_[c];
    for (std::size_t q = 0; q < child.to_parent.size(); ++q) {
      const Run& columns = child.to_parent[q];
      for (int j = 0; j < columns.count; ++j) {
        const int column = columns.to + j;
        double* target = column < front.own_rows
                             ? &front.panel(0, column)
                             : &front.update(0, column - front.own_rows) - front.own_rows;
        const double* source = &child.update(0, columns.from + j);
        for (std::size_t p = q; p < child.to_parent.size(); ++p) {
          const Run& rows = child.to_parent[p];
          for (int i = p == q ? j : 0; i < rows.count; ++i)
            target[rows.to + i] += source[rows.from + i];
        }
      }
    }
  }
}

bool Factor::compute(const ColumnMatrix& h, double shift) {
  const DenseKernels& kernels = dense_kernels();
  for (Front& front : fronts_) {
    assemble(h, shift, front);
    const int n = front.own_rows;
    const int rows = front.rest_rows;
    const int stride = n + rows;
    double* panel = front.panel.data();
    if (!kernels.cholesky(panel, n, stride)) return false;
    if (rows == 0) continue;
    kernels.solve_right(panel, n, stride, panel + n, rows, stride);
    kernels.subtract_square(panel + n, rows, n, stride, front.update.data(), rows);
  }
  return true;
}

void Factor::solve_one(double* y) const {
  const DenseKernels& kernels = dense_kernels();
  std::vector<double> part;
  for (const Front& front : fronts_) {
    const int stride = front.own_rows + front.rest_rows;
    part.resize(front.rest_rows);
    kernels.forward(front.panel.data(),
                    front.own_rows,
                    front.rest_rows,
                    stride,
                    y + front.own_begin,
                    part.data());
    for (const Run& run : front.rest) {
      for (int i = 0; i < run.count; ++i) y[run.to + i] -= part[run.from + i];
    }
  }
  for (auto it = fronts_.rbegin(); it != fronts_.rend(); ++it) {
    const Front& front = *it;
    const int stride = front.own_rows + front.rest_rows;
    part.resize(front.rest_rows);
    for (const Run& run : front.rest) std::copy_n(y + run.to, run.count, part.data() + run.from);
    kernels.backward(front.panel.data(),
                     front.own_rows,
                     front.rest_rows,
                     stride,
                     y + front.own_begin,
                     part.data());
  }
}

void Factor::solve_many(Eigen::Ref<MatrixXd> y) const {
  MatrixXd part;
  for (const Front& front : fronts_) {
    auto mine = y.middleRows(front.own_begin, front.own_rows);
    front.panel.topRows(front.own_rows).triangularView<Eigen::Lower>().solveInPlace(mine);
    part.noalias() = front.panel.bottomRows(front.rest_rows) * mine;
    for (const Run& run : front.rest) {
      y.middleRows(run.to, run.count) -= part.middleRows(run.from, run.count);
    }
  }
  for (auto it = fronts_.rbegin(); it != fronts_.rend(); ++it) {
    const Front& front = *it;
    auto mine = y.middleRows(front.own_begin, front.own_rows);
    part.resize(front.rest_rows, y.cols());
    for (const Run& run : front.rest) {
      part.middleRows(run.from, run.count) = y.middleRows(run.to, run.count);
    }
    mine.noalias() -= front.panel.bottomRows(front.rest_rows).transpose() * part;
    front.panel.topRows(front.own_rows)
        .triangularView<Eigen::Lower>()
        .transpose()
        .solveInPlace(mine);
  }
}

void Factor::solve(Eigen::Ref<MatrixXd> x) const {
  assert(x.rows() == num_unknowns_);
  const Eigen::Index num_nodes = static_cast<Eigen::Index>(node_.size());
  MatrixXd y(3 * num_nodes, x.cols());
  for (Eigen::Index k = 0; k < num_nodes; ++k)
    y.middleRows<3>(3 * k) = x.middleRows<3>(3 * node_[k]);
  if (y.cols() == 1) {
    solve_one(y.data());
  } else {
    solve_many(y);
  }
  x.setZero();
  for (Eigen::Index k = 0; k < num_nodes; ++k)
    x.middleRows<3>(3 * node_[k]) = y.middleRows<3>(3 * k);
}

std::size_t Factor::size() const {
  std::size_t sum = 0;
  for (const Front& front : fronts_) sum += static_cast<std::size_t>(front.panel.size());
  return sum;
}

}  // namespace zygoma
