#include "face/solvers/factor.h"

#include <algorithm>
#include <cassert>

#include "face/solvers/dense_kernels.h"

namespace zygoma {
namespace {

constexpr int kLeafColumns = 8;  // smaller pieces are not halved any more

using Eigen::MatrixXd;

}  // namespace

Factor::Factor(const std::vector<Vec3>& positions_mm, const ColumnMatrix& pattern)
    : block_(pattern.block), num_columns_(pattern.num_columns) {
  assert(static_cast<int>(positions_mm.size()) == num_columns_);
  neighbors_.resize(num_columns_);
  for (const auto& [a, b] : pattern.edges) {
    neighbors_[a].push_back(b);
    neighbors_[b].push_back(a);
  }
  std::vector<int> all(num_columns_);
  for (int v = 0; v < num_columns_; ++v) all[v] = v;
  dissect(std::move(all), positions_mm, -1);
  // Parents were created before their children; elimination runs the other way.
  const int last = static_cast<int>(fronts_.size()) - 1;
  std::reverse(fronts_.begin(), fronts_.end());
  for (int f = 0; f <= last; ++f) {
    Front& front = fronts_[f];
    if (front.parent >= 0) front.parent = last - front.parent;
  }
  position_.assign(num_columns_, 0);
  std::vector<int> order;
  for (Front& front : fronts_) {
    const int begin = static_cast<int>(order.size());
    for (int p = front.own_begin; p < front.own_end; ++p) order.push_back(order_[p]);
    front.own_begin = begin;
    front.own_end = static_cast<int>(order.size());
  }
  order_ = std::move(order);
  for (int p = 0; p < num_columns_; ++p) position_[order_[p]] = p;
  for (int f = 0; f <= last; ++f) {
    if (fronts_[f].parent >= 0) fronts_[fronts_[f].parent].children.push_back(f);
  }
  find_boundaries();
  place_pieces(pattern);
}

// Appends a front for the seam of `columns` (or all of a small piece), then its halves.
void Factor::dissect(std::vector<int> columns, const std::vector<Vec3>& positions_mm, int parent) {
  if (columns.empty()) return;
  std::vector<int> lower;
  std::vector<int> upper;
  std::vector<int> seam;
  if (static_cast<int>(columns.size()) <= kLeafColumns) {
    seam = std::move(columns);
  } else {
    Vec3 smallest = positions_mm[columns[0]];
    Vec3 largest = smallest;
    for (const int v : columns) {
      smallest = smallest.cwiseMin(positions_mm[v]);
      largest = largest.cwiseMax(positions_mm[v]);
    }
    int axis = 0;
    (largest - smallest).maxCoeff(&axis);
    std::sort(columns.begin(), columns.end(), [&](int a, int b) {
      return std::pair(positions_mm[a][axis], a) < std::pair(positions_mm[b][axis], b);
    });
    std::vector<char> side(num_columns_, 0);
    const std::size_t half = columns.size() / 2;
    for (std::size_t k = 0; k < columns.size(); ++k) side[columns[k]] = k < half ? 1 : 2;
    const auto touches = [&](int v, char other) {
      return std::any_of(
          neighbors_[v].begin(), neighbors_[v].end(), [&](int u) { return side[u] == other; });
    };
    std::array<std::vector<int>, 2> rim;
    for (const int v : columns) {
      const char own = side[v];
      if (touches(v, own == 1 ? 2 : 1)) rim[own - 1].push_back(v);
    }
    seam = rim[0].size() <= rim[1].size() ? rim[0] : rim[1];
    for (const int v : seam) side[v] = 3;
    for (const int v : columns) {
      if (side[v] == 1) lower.push_back(v);
      if (side[v] == 2) upper.push_back(v);
    }
  }
  Front front;
  front.parent = parent;
  front.own_begin = static_cast<int>(order_.size());
  order_.insert(order_.end(), seam.begin(), seam.end());
  front.own_end = static_cast<int>(order_.size());
  const int index = static_cast<int>(fronts_.size());
  fronts_.push_back(std::move(front));
  dissect(std::move(lower), positions_mm, index);
  dissect(std::move(upper), positions_mm, index);
}

void Factor::find_boundaries() {
  for (Front& front : fronts_) {
    std::vector<int>& boundary = front.boundary;
    for (int p = front.own_begin; p < front.own_end; ++p) {
      for (const int u : neighbors_[order_[p]]) boundary.push_back(position_[u]);
    }
    for (const int child : front.children) {
      boundary.insert(
          boundary.end(), fronts_[child].boundary.begin(), fronts_[child].boundary.end());
    }
    std::erase_if(boundary, [&](int p) { return p < front.own_end; });
    std::sort(boundary.begin(), boundary.end());
    boundary.erase(std::unique(boundary.begin(), boundary.end()), boundary.end());
  }
  for (Front& front : fronts_) {
    const int own = block_ * (front.own_end - front.own_begin);
    const int rest = block_ * static_cast<int>(front.boundary.size());
    front.panel.resize(own + rest, own);
    front.update.resize(rest, rest);
    if (front.parent < 0) continue;
    const Front& parent = fronts_[front.parent];
    for (const int p : front.boundary) {
      if (p < parent.own_end) {
        front.place_in_parent.push_back(p - parent.own_begin);
        continue;
      }
      const auto at = std::lower_bound(parent.boundary.begin(), parent.boundary.end(), p);
      assert(at != parent.boundary.end() && *at == p);
      front.place_in_parent.push_back(parent.own_end - parent.own_begin +
                                      static_cast<int>(at - parent.boundary.begin()));
    }
  }
}

void Factor::place_pieces(const ColumnMatrix& pattern) {
  std::vector<int> front_of(num_columns_);
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    for (int p = fronts_[f].own_begin; p < fronts_[f].own_end; ++p) {
      front_of[p] = static_cast<int>(f);
    }
  }
  const std::size_t size = static_cast<std::size_t>(block_) * block_;
  const auto place = [&](std::size_t slot, int row, int column) {
    const bool transposed = position_[row] < position_[column];
    const int first = std::min(position_[row], position_[column]);
    const int second = std::max(position_[row], position_[column]);
    Front& front = fronts_[front_of[first]];
    const int own = front.own_end - front.own_begin;
    int at = second - front.own_begin;
    if (second >= front.own_end) {
      at = own +
           static_cast<int>(std::lower_bound(front.boundary.begin(), front.boundary.end(), second) -
                            front.boundary.begin());
    }
    front.pieces.push_back({slot * size, at, first - front.own_begin, transposed});
  };
  for (int v = 0; v < num_columns_; ++v) place(v, v, v);
  for (std::size_t e = 0; e < pattern.edges.size(); ++e) {
    place(num_columns_ + e, pattern.edges[e][1], pattern.edges[e][0]);
  }
}

void Factor::assemble(const ColumnMatrix& h, double shift, Front& front) {
  const int b = block_;
  front.panel.setZero();
  front.update.setZero();
  for (const Piece& piece : front.pieces) {
    const Eigen::Map<const MatrixXd> source(&h.values[piece.values_begin], b, b);
    auto target = front.panel.block(b * piece.row, b * piece.column, b, b);
    if (piece.transposed) {
      target = source.transpose();
    } else {
      target = source;
    }
  }
  if (shift != 0.0) front.panel.diagonal().array() += shift;
  const int own = front.own_end - front.own_begin;
  for (const int c : front.children) {
    const Front& child = fronts_[c];
    const int n = static_cast<int>(child.place_in_parent.size());
    for (int j = 0; j < n; ++j) {
      const int column = child.place_in_parent[j];
      for (int i = j; i < n; ++i) {
        const int row = child.place_in_parent[i];
        const auto source = child.update.block(b * i, b * j, b, b);
        if (column < own) {
          front.panel.block(b * row, b * column, b, b) += source;
        } else {
          front.update.block(b * (row - own), b * (column - own), b, b) += source;
        }
      }
    }
  }
}

bool Factor::compute(const ColumnMatrix& h, double shift) {
  const DenseKernels& kernels = dense_kernels();
  for (Front& front : fronts_) {
    assemble(h, shift, front);
    const Eigen::Index own = front.panel.cols();
    const Eigen::Index rest = front.panel.rows() - own;
    if (own == 0) continue;  // the seam of two pieces that do not touch
    const int n = static_cast<int>(own);
    const int rows = static_cast<int>(rest);
    const int stride = n + rows;
    double* panel = front.panel.data();
    if (!kernels.cholesky(panel, n, stride)) return false;
    if (rest == 0) continue;
    kernels.solve_right(panel, n, stride, panel + n, rows, stride);
    kernels.subtract_square(panel + n, rows, n, stride, front.update.data(), rows);
  }
  return true;
}

void Factor::solve_one(double* y) const {
  const DenseKernels& kernels = dense_kernels();
  const int b = block_;
  std::vector<double> part;
  for (const Front& front : fronts_) {
    const int own = static_cast<int>(front.panel.cols());
    const int rest = static_cast<int>(front.panel.rows()) - own;
    if (own == 0) continue;
    part.resize(rest);
    kernels.forward(
        front.panel.data(), own, rest, own + rest, y + b * front.own_begin, part.data());
    for (std::size_t k = 0; k < front.boundary.size(); ++k) {
      double* to = y + b * front.boundary[k];
      for (int i = 0; i < b; ++i) to[i] -= part[b * k + i];
    }
  }
  for (auto it = fronts_.rbegin(); it != fronts_.rend(); ++it) {
    const Front& front = *it;
    const int own = static_cast<int>(front.panel.cols());
    const int rest = static_cast<int>(front.panel.rows()) - own;
    if (own == 0) continue;
    part.resize(rest);
    for (std::size_t k = 0; k < front.boundary.size(); ++k) {
      const double* from = y + b * front.boundary[k];
      std::copy(from, from + b, &part[b * k]);
    }
    kernels.backward(
        front.panel.data(), own, rest, own + rest, y + b * front.own_begin, part.data());
  }
}

void Factor::solve_many(Eigen::Ref<MatrixXd> y) const {
  const int b = block_;
  MatrixXd part;
  for (const Front& front : fronts_) {
    const Eigen::Index own = front.panel.cols();
    const Eigen::Index rest = front.panel.rows() - own;
    if (own == 0) continue;
    auto mine = y.middleRows(b * front.own_begin, own);
    front.panel.topRows(own).triangularView<Eigen::Lower>().solveInPlace(mine);
    if (rest == 0) continue;
    part.noalias() = front.panel.bottomRows(rest) * mine;
    for (std::size_t k = 0; k < front.boundary.size(); ++k) {
      y.middleRows(b * front.boundary[k], b) -= part.middleRows(b * k, b);
    }
  }
  for (auto it = fronts_.rbegin(); it != fronts_.rend(); ++it) {
    const Front& front = *it;
    const Eigen::Index own = front.panel.cols();
    const Eigen::Index rest = front.panel.rows() - own;
    if (own == 0) continue;
    auto mine = y.middleRows(b * front.own_begin, own);
    if (rest > 0) {
      part.resize(rest, y.cols());
      for (std::size_t k = 0; k < front.boundary.size(); ++k) {
        part.middleRows(b * k, b) = y.middleRows(b * front.boundary[k], b);
      }
      mine.noalias() -= front.panel.bottomRows(rest).transpose() * part;
    }
    front.panel.topRows(own).triangularView<Eigen::Lower>().transpose().solveInPlace(mine);
  }
}

void Factor::solve(Eigen::Ref<MatrixXd> x) const {
  const int layers = block_ / 3;
  MatrixXd y(x.rows(), x.cols());
  for (int p = 0; p < num_columns_; ++p) {
    for (int layer = 0; layer < layers; ++layer) {
      y.middleRows<3>(block_ * p + 3 * layer) =
          x.middleRows<3>(3 * (layer * num_columns_ + order_[p]));
    }
  }
  if (y.cols() == 1) {
    solve_one(y.data());
  } else {
    solve_many(y);
  }
  for (int p = 0; p < num_columns_; ++p) {
    for (int layer = 0; layer < layers; ++layer) {
      x.middleRows<3>(3 * (layer * num_columns_ + order_[p])) =
          y.middleRows<3>(block_ * p + 3 * layer);
    }
  }
}

std::size_t Factor::size() const {
  std::size_t sum = 0;
  for (const Front& front : fronts_) sum += static_cast<std::size_t>(front.panel.size());
  return sum;
}

}  // namespace zygoma
