#include "face/solvers/factor.h"

#include <algorithm>
#include <cassert>
#include <type_traits>

#include "face/solvers/elimination.h"

namespace zygoma {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void append(std::vector<Run>& runs, const Run& run) {
  if (!runs.empty() && runs.back().from + runs.back().count == run.from &&
      runs.back().to + runs.back().count == run.to) {
    runs.back().count += run.count;
  } else {
    runs.push_back(run);
  }
}

}  // namespace

Factor::Factor(const ColumnMatrix& pattern, const DenseKernels& kernels)
    : kernels_(&kernels), num_unknowns_(pattern.num_unknowns()) {
  std::vector<int> columns;  // that have unknowns
  for (int c = 0; c < pattern.num_columns(); ++c) {
    if (pattern.rows(c) > 0) columns.push_back(c);
  }
  make_fronts(pattern, columns, Order::kWanted);
  place_storage();
}

Factor::Factor(const ColumnMatrix& pattern,
               const std::vector<int>& columns,
               const DenseKernels& kernels)
    : kernels_(&kernels), num_unknowns_(pattern.num_unknowns()) {
  make_fronts(pattern, columns, Order::kGiven);
  place_storage();
}

void Factor::make_fronts(const ColumnMatrix& pattern,
                         const std::vector<int>& columns,
                         Order order) {
  std::vector<int> part(pattern.num_columns(), -1);  // number of a column among those
  std::vector<int> weights;
  for (const int c : columns) {
    part[c] = static_cast<int>(weights.size());
    weights.push_back(pattern.rows(c));
  }
  std::vector<std::vector<int>> neighbors(columns.size());
  for (const auto& [first, second] : pattern.edges) {
    if (part[first] < 0 || part[second] < 0) continue;
    neighbors[part[first]].push_back(part[second]);
    neighbors[part[second]].push_back(part[first]);
  }
  const std::vector<FrontColumns> plan = order == Order::kGiven
                                             ? plan_elimination_in_order(neighbors, weights)
                                             : plan_elimination(neighbors, weights);
  std::vector<int> begin(columns.size());  // of each column in the elimination order
  std::vector<int> front_of(columns.size());
  fronts_.resize(plan.size());
  int next = 0;
  for (std::size_t f = 0; f < plan.size(); ++f) {
    Front& front = fronts_[f];
    front.own_begin = next;
    for (const int v : plan[f].own) {
      begin[v] = next;
      front_of[v] = static_cast<int>(f);
      next += weights[v];
      columns_.push_back(columns[v]);
      const std::vector<int>& nodes = pattern.nodes[columns[v]];
      node_.insert(node_.end(), nodes.begin(), nodes.end());
    }
    front.own = next - front.own_begin;
    front.height = front.own;
    for (const int v : plan[f].rest) front.height += weights[v];
  }
  const auto place_in = [&](int f, int v) {
    if (front_of[v] == f) return begin[v] - fronts_[f].own_begin;
    int place = fronts_[f].own;
    for (const int u : plan[f].rest) {
      if (u == v) break;
      place += weights[u];
    }
    assert(place < fronts_[f].height);
    return place;
  };
  for (std::size_t f = 0; f < plan.size(); ++f) {
    Front& front = fronts_[f];
    const int parent = plan[f].parent;
    int from = front.own;
    for (const int v : plan[f].rest) {
      append(front.rest, {from, begin[v], weights[v]});
      append(front.to_parent, {from, place_in(parent, v), weights[v]});
      from += weights[v];
    }
    if (parent >= 0) fronts_[parent].children.push_back(static_cast<int>(f));
  }
  const auto place_piece = [&](std::size_t block, int v, int u) {
    const bool transposed = begin[v] < begin[u];  // the block's rows are those of v
    if (transposed) std::swap(v, u);
    const int f = front_of[u];
    fronts_[f].pieces.push_back(
        {pattern.begin[block], place_in(f, v), place_in(f, u), weights[v], weights[u], transposed});
  };
  for (std::size_t v = 0; v < columns.size(); ++v) {
    place_piece(columns[v], static_cast<int>(v), static_cast<int>(v));
  }
  for (std::size_t e = 0; e < pattern.edges.size(); ++e) {
    const auto& [first, second] = pattern.edges[e];
    if (part[first] < 0 || part[second] < 0) continue;
    place_piece(pattern.nodes.size() + e, part[second], part[first]);
  }
}

void Factor::place_storage() {
  std::array<std::size_t, 2> top{};
  std::array<std::size_t, 2> most{};
  for (std::size_t f = fronts_.size(); f-- > 0;) {
    for (const int child : fronts_[f].children) fronts_[child].stack = 1 - fronts_[f].stack;
  }
  std::size_t size = 0;
  for (Front& front : fronts_) {
    front.panels_begin = size;
    size += panels_size(front.own, front.height);
    largest_height_ = std::max(largest_height_, front.height);
    std::size_t& mine = top[front.stack];
    front.stack_begin = mine;
    mine += front_size(front.height);
    most[front.stack] = std::max(most[front.stack], mine);
    for (const int c : front.children) top[1 - front.stack] -= front_size(fronts_[c].height);
    if (front.to_parent.empty()) mine = front.stack_begin;  // nobody waits for it
  }
  panels_.resize(size);
  rough_panels_.resize(size);
  for (int s = 0; s < 2; ++s) stacks_[s].resize(most[s]);
  work_.resize(static_cast<std::size_t>(kPanelWidth) * front_stride(largest_height_));
}

double* Factor::assemble(const ColumnMatrix& h, double shift, const Front& front) {
  const int stride = front_stride(front.height);
  double* matrix = stacks_[front.stack].data() + front.stack_begin;
  const auto column = [&](int c) { return matrix + static_cast<std::size_t>(c) * stride; };
  // Above the diagonal too: what children leave there means nothing, but must not pile up.
  for (int c = 0; c < front.height; ++c) std::fill_n(column(c), front.height, 0.0);
  for (const Piece& p : front.pieces) {
    const Eigen::OuterStride<> apart(stride);
    Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>> target(
        column(p.column) + p.row, p.num_rows, p.num_columns, apart);
    const double* values = h.values.data() + p.values_begin;
    if (p.transposed) {
      target = Eigen::Map<const MatrixXd>(values, p.num_columns, p.num_rows).transpose();
    } else {
      target = Eigen::Map<const MatrixXd>(values, p.num_rows, p.num_columns);
    }
  }
  for (int c = 0; c < front.own; ++c) column(c)[c] += shift;
  for (const int c : front.children) {
    const Front& child = fronts_[c];
    const int child_stride = front_stride(child.height);
    const double* rest = stacks_[child.stack].data() + child.stack_begin;
    const int num_runs = static_cast<int>(child.to_parent.size());
    for (int r = 0; r < num_runs; ++r) {
      // The rows before the diagonal that this takes along are above the diagonal here as well.
      const Run& run = child.to_parent[r];
      for (int j = 0; j < run.count; ++j) {
        kernels_->add(rest + static_cast<std::size_t>(run.from + j) * child_stride,
                      column(run.to + j),
                      &run,
                      num_runs - r);
      }
    }
  }
  return matrix;
}

bool Factor::compute(const ColumnMatrix& h, double shift) {
  for (const Front& front : fronts_) {
    double* panels = panels_.data() + front.panels_begin;
    if (!kernels_->eliminate(
            assemble(h, shift, front), front.own, front.height, panels, work_.data())) {
      return false;
    }
    const std::size_t size = panels_size(front.own, front.height);
    std::copy_n(panels, size, rough_panels_.data() + front.panels_begin);
  }
  return true;
}

template <class T>
void Factor::solve_one(const AlignedVector<T>& panels, Eigen::Ref<VectorXd> x) const {
  AlignedVector<T> y(3 * node_.size());
  for (std::size_t k = 0; k < node_.size(); ++k) {
    for (int a = 0; a < 3; ++a) y[3 * k + a] = static_cast<T>(x[3 * node_[k] + a]);
  }
  solve_in_order(panels, y);
  x.setZero();
  for (std::size_t k = 0; k < node_.size(); ++k) {
    for (int a = 0; a < 3; ++a) x[3 * node_[k] + a] = static_cast<double>(y[3 * k + a]);
  }
}

template <class T>
void Factor::solve_in_order(const AlignedVector<T>& panels, AlignedVector<T>& y) const {
  constexpr bool rough = std::is_same_v<T, float>;
  AlignedVector<T> v(round_up(largest_height_, kStripRows));
  const auto forward = [&] {
    if constexpr (rough)
      return kernels_->forward_float;
    else
      return kernels_->forward;
  }();
  const auto backward = [&] {
    if constexpr (rough)
      return kernels_->backward_float;
    else
      return kernels_->backward;
  }();
  for (const Front& front : fronts_) {
    T* own = y.data() + front.own_begin;
    std::copy_n(own, front.own, v.data());
    std::fill_n(v.data() + front.own, front.height - front.own, T(0));
    forward(panels.data() + front.panels_begin, front.own, front.height, v.data());
    std::copy_n(v.data(), front.own, own);
    for (const Run& run : front.rest) {
      for (int i = 0; i < run.count; ++i) y[run.to + i] += v[run.from + i];
    }
  }
  for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
    T* own = y.data() + front->own_begin;
    std::copy_n(own, front->own, v.data());
    for (const Run& run : front->rest) {
      std::copy_n(y.data() + run.to, run.count, v.data() + run.from);
    }
    backward(panels.data() + front->panels_begin, front->own, front->height, v.data());
    std::copy_n(v.data(), front->own, own);
  }
}

// As many right-hand sides as the kernels take at once, row by row.
void Factor::solve_some(Eigen::Ref<MatrixXd> x) const {
  const int count = static_cast<int>(x.cols());
  const int width = round_up(count, kernels_->right_hand_side_step);
  AlignedVector<double> y(3 * node_.size() * width);
  for (std::size_t k = 0; k < node_.size(); ++k) {
    for (int c = 0; c < count; ++c) {
      for (int a = 0; a < 3; ++a) y[(3 * k + a) * width + c] = x(3 * node_[k] + a, c);
    }
  }
  AlignedVector<double> v(round_up(largest_height_, kStripRows) * width);
  const auto is_zero = [](double value) { return value == 0.0; };
  for (const Front& front : fronts_) {
    double* own = y.data() + static_cast<std::size_t>(front.own_begin) * width;
    const std::size_t own_size = static_cast<std::size_t>(front.own) * width;
    if (std::all_of(own, own + own_size, is_zero)) continue;
    std::copy_n(own, own_size, v.data());
    std::fill_n(v.data() + own_size, (front.height - front.own) * width, 0.0);
    kernels_->forward_many(
        panels_.data() + front.panels_begin, front.own, front.height, width, v.data());
    std::copy_n(v.data(), own_size, own);
    for (const Run& run : front.rest) {
      const Run entries{run.from * width, run.to * width, run.count * width};
      kernels_->add(v.data(), y.data(), &entries, 1);
    }
  }
  for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
    double* own = y.data() + static_cast<std::size_t>(front->own_begin) * width;
    const std::size_t own_size = static_cast<std::size_t>(front->own) * width;
    std::copy_n(own, own_size, v.data());
    for (const Run& run : front->rest) {
      std::copy_n(y.data() + static_cast<std::size_t>(run.to) * width,
                  run.count * width,
                  v.data() + static_cast<std::size_t>(run.from) * width);
    }
    kernels_->backward_many(
        panels_.data() + front->panels_begin, front->own, front->height, width, v.data());
    std::copy_n(v.data(), own_size, own);
  }
  x.setZero();
  for (std::size_t k = 0; k < node_.size(); ++k) {
    for (int c = 0; c < count; ++c) {
      for (int a = 0; a < 3; ++a) x(3 * node_[k] + a, c) = y[(3 * k + a) * width + c];
    }
  }
}

void Factor::solve(Eigen::Ref<MatrixXd> x) const {
  assert(x.rows() == num_unknowns_);
  const Eigen::Index most = kernels_->most_right_hand_sides;
  for (Eigen::Index c = 0; c < x.cols(); c += most) {
    const Eigen::Index count = std::min(most, x.cols() - c);
    if (count == 1) {
      solve_one(panels_, x.col(c));
    } else {
      solve_some(x.middleCols(c, count));
    }
  }
}

void Factor::solve_roughly(Eigen::Ref<VectorXd> x) const {
  assert(x.size() == num_unknowns_);
  solve_one(rough_panels_, x);
}

void Factor::solve_roughly_in_order(Eigen::Ref<VectorXd> y) const {
  assert(y.size() == 3 * static_cast<Eigen::Index>(node_.size()));
  AlignedVector<float> rough(y.begin(), y.end());
  solve_in_order(rough_panels_, rough);
  std::copy(rough.begin(), rough.end(), y.begin());
}

}  // namespace zygoma
