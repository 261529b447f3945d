#include "tracker/snake.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace zygoma {
namespace {

constexpr double kShortest = 1e-9;  // px, below it a spring has no direction
constexpr size_t kRemembered = 10;  // states compared to tell oscillation from motion

Point2 direction(const Point2& from, const Point2& to) {
  const Point2 r = to - from;
  const double length = r.norm();
  return length > kShortest ? Point2(r / length) : Point2::Zero();
}

double largest_move(const std::vector<Point2>& a, const std::vector<Point2>& b) {
  double largest = 0.0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

bool all_finite(const std::vector<Point2>& points) {
  return std::all_of(points.begin(), points.end(), [](const Point2& p) { return p.allFinite(); });
}

}  // namespace

std::string_view to_string(SnakeStop stop) {
  switch (stop) {
    case SnakeStop::kConverged:
      return "converged";
    case SnakeStop::kOscillating:
      return "oscillating";
    case SnakeStop::kIterationLimit:
      return "iteration limit";
    case SnakeStop::kNotFinite:
      return "not finite";
  }
  return "unknown";
}

Snake::Snake(std::vector<Point2> nodes, const SnakeOptions& options)
    : options_(options), nodes_(std::move(nodes)) {
  assert(nodes_.size() >= 3);
  for (size_t i = 0; i + 1 < nodes_.size(); ++i) {
    rest_lengths_.push_back((nodes_[i + 1] - nodes_[i]).norm());
  }
  initial_lengths_ = rest_lengths_;
  factor();
}

void Snake::set_nodes(std::vector<Point2> nodes) {
  assert(nodes.size() == nodes_.size());
  nodes_ = std::move(nodes);
}

void Snake::set_anchors(std::vector<SoftAnchor> anchors) {
  assert(anchors.empty() || anchors.size() == nodes_.size());
  anchors_ = std::move(anchors);
  factor();
}

double Snake::internal_energy() const {
  double energy = 0.0;
  for (size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const double e = (nodes_[i + 1] - nodes_[i]).norm() - rest_lengths_[i];
    energy += 0.5 * options_.tension * e * e;
  }
  for (size_t i = 1; i + 1 < nodes_.size(); ++i) {
    energy +=
        0.5 * options_.rigidity * (nodes_[i + 1] - 2.0 * nodes_[i] + nodes_[i - 1]).squaredNorm();
  }
  return energy;
}

std::vector<Point2> Snake::internal_force() const {
  std::vector<Point2> force(nodes_.size(), Point2::Zero());
  for (size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const double e = (nodes_[i + 1] - nodes_[i]).norm() - rest_lengths_[i];
    const Point2 pull = options_.tension * e * direction(nodes_[i], nodes_[i + 1]);
    force[i] += pull;
    force[i + 1] -= pull;
  }
  for (size_t i = 1; i + 1 < nodes_.size(); ++i) {
    const Point2 bend = options_.rigidity * (nodes_[i + 1] - 2.0 * nodes_[i] + nodes_[i - 1]);
    force[i - 1] -= bend;
    force[i] += 2.0 * bend;
    force[i + 1] -= bend;
  }
  return force;
}

void Snake::factor() {
  const size_t n = nodes_.size();
  const double a = options_.tension;
  const double b = options_.rigidity;
  std::vector<double> h0(n, options_.damping / options_.step), h1(n, 0.0), h2(n, 0.0);
  for (size_t i = 0; i + 1 < n; ++i) {
    h0[i] += a;
    h0[i + 1] += a;
    h1[i] -= a;
  }
  for (size_t i = 1; i + 1 < n; ++i) {
    h0[i - 1] += b;
    h0[i] += 4.0 * b;
    h0[i + 1] += b;
    h1[i - 1] -= 2.0 * b;
    h1[i] -= 2.0 * b;
    h2[i - 1] += b;
  }
  for (size_t i = 0; i < anchors_.size(); ++i) h0[i] += anchors_[i].weight;
  diagonal_.assign(n, 0.0);
  lower1_.assign(n, 0.0);
  lower2_.assign(n, 0.0);
  for (size_t i = 0; i < n; ++i) {
    double d = h0[i];
    double first = h1[i];
    if (i >= 1) {
      d -= lower1_[i - 1] * lower1_[i - 1] * diagonal_[i - 1];
      first -= lower1_[i - 1] * lower2_[i - 1] * diagonal_[i - 1];
    }
    if (i >= 2) d -= lower2_[i - 2] * lower2_[i - 2] * diagonal_[i - 2];
    diagonal_[i] = d;
    lower1_[i] = first / d;
    lower2_[i] = h2[i] / d;
  }
}

void Snake::solve(std::vector<Point2>& x) const {
  const size_t n = x.size();
  for (size_t i = 0; i < n; ++i) {
    if (i >= 1) x[i] -= lower1_[i - 1] * x[i - 1];
    if (i >= 2) x[i] -= lower2_[i - 2] * x[i - 2];
  }
  for (size_t i = 0; i < n; ++i) x[i] /= diagonal_[i];
  for (size_t i = n; i-- > 0;) {
    if (i + 1 < n) x[i] -= lower1_[i] * x[i + 1];
    if (i + 2 < n) x[i] -= lower2_[i] * x[i + 2];
  }
}

double Snake::advance(const ImageLandscape* image) {
  const size_t n = nodes_.size();
  const double inertia = options_.damping / options_.step;
  std::vector<Point2> next(n);
  for (size_t i = 0; i < n; ++i) next[i] = inertia * nodes_[i];
  for (size_t i = 0; i + 1 < n; ++i) {
    const Point2 push = options_.tension * rest_lengths_[i] * direction(nodes_[i], nodes_[i + 1]);
    next[i] -= push;
    next[i + 1] += push;
  }
  for (size_t i = 0; i < anchors_.size(); ++i) next[i] += anchors_[i].weight * anchors_[i].target;
  if (image != nullptr) {
    for (size_t i = 0; i < n; ++i) {
      next[i] -= options_.image_weight * image->gradient(i, nodes_[i]);
    }
  }
  solve(next);
  if (!all_finite(next)) return std::numeric_limits<double>::quiet_NaN();
  double largest = 0.0;
  for (size_t i = 0; i < n; ++i) {
    Point2 move = next[i] - nodes_[i];
    const double length = move.norm();
    // The cap tames the explicit image force; a chain without an image needs none.
    if (image != nullptr && length > 0.0) {
      move *= options_.step_cap_px * std::tanh(length / options_.step_cap_px) / length;
    }
    nodes_[i] += move;
    largest = std::max(largest, move.norm());
  }
  if (options_.viscosity > 0.0) {
    for (size_t i = 0; i + 1 < n; ++i) {
      const double e = (nodes_[i + 1] - nodes_[i]).norm() - rest_lengths_[i];
      rest_lengths_[i] = std::clamp(rest_lengths_[i] + options_.step * options_.viscosity * e,
                                    options_.min_length * initial_lengths_[i],
                                    options_.max_length * initial_lengths_[i]);
    }
  }
  return largest;
}

SnakeReport Snake::relax(const ImageLandscape* image) {
  SnakeReport report;
  std::array<std::vector<Point2>, kRemembered> past;
  for (; report.iterations < options_.max_iterations; ++report.iterations) {
    past[static_cast<size_t>(report.iterations) % kRemembered] = nodes_;
    report.last_move_px = advance(image);
    if (!std::isfinite(report.last_move_px)) {
      report.stop = SnakeStop::kNotFinite;
      return report;
    }
    if (report.last_move_px < options_.tolerance_px) {
      report.stop = SnakeStop::kConverged;
      return report;
    }
    for (const std::vector<Point2>& state : past) {
      if (!state.empty() && largest_move(state, nodes_) < options_.tolerance_px) {
        report.stop = SnakeStop::kOscillating;
        return report;
      }
    }
  }
  return report;
}

std::vector<Point2> resample(const std::vector<Point2>& line, int num_points) {
  assert(line.size() >= 2 && num_points >= 2);
  std::vector<double> length(line.size(), 0.0);
  for (size_t i = 1; i < line.size(); ++i)
    length[i] = length[i - 1] + (line[i] - line[i - 1]).norm();
  std::vector<Point2> out;
  size_t segment = 0;
  for (int k = 0; k < num_points; ++k) {
    const double s = length.back() * k / (num_points - 1);
    while (segment + 2 < line.size() && length[segment + 1] < s) ++segment;
    const double part = length[segment + 1] - length[segment];
    const double u = part > 0.0 ? std::clamp((s - length[segment]) / part, 0.0, 1.0) : 0.0;
    out.push_back((1.0 - u) * line[segment] + u * line[segment + 1]);
  }
  out.back() = line.back();
  return out;
}

}  // namespace zygoma
