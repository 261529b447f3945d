#include "tracker/snake.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "src/base/check.h"

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

double explicit_step_bound(const SnakeOptions& options,
                           double strongest_anchor,
                           double image_curvature) {
  return 2.0 * options.damping /
         (4.0 * options.tension + 16.0 * options.rigidity + strongest_anchor +
          options.image_weight * image_curvature);
}

Snake::Snake(std::vector<Point2> nodes, const SnakeOptions& options)
    : options_(options), nodes_(std::move(nodes)) {
  const bool closed = options_.ends == SnakeEnds::kClosed;
  assert(nodes_.size() >= (closed ? 5 : 3));
  rest_lengths_.resize(closed ? nodes_.size() : nodes_.size() - 1);
  for (size_t i = 0; i < num_springs(); ++i) {
    rest_lengths_[i] = (nodes_[next(i)] - nodes_[i]).norm();
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
  for (size_t i = 0; i < num_springs(); ++i) {
    const double e = (nodes_[next(i)] - nodes_[i]).norm() - rest_lengths_[i];
    energy += 0.5 * options_.tension * e * e;
  }
  for (size_t i = 0; i < num_bends(); ++i) {
    const size_t j = next(i);
    const Point2 k = nodes_[next(j)] - 2.0 * nodes_[j] + nodes_[i];
    energy += 0.5 * options_.rigidity * k.squaredNorm();
  }
  return energy;
}

std::vector<Point2> Snake::internal_force() const {
  std::vector<Point2> force(nodes_.size(), Point2::Zero());
  for (size_t i = 0; i < num_springs(); ++i) {
    const size_t j = next(i);
    const double e = (nodes_[j] - nodes_[i]).norm() - rest_lengths_[i];
    const Point2 pull = options_.tension * e * direction(nodes_[i], nodes_[j]);
    force[i] += pull;
    force[j] -= pull;
  }
  for (size_t i = 0; i < num_bends(); ++i) {
    const size_t j = next(i);
    const size_t k = next(j);
    const Point2 bend = options_.rigidity * (nodes_[k] - 2.0 * nodes_[j] + nodes_[i]);
    force[i] -= bend;
    force[j] += 2.0 * bend;
    force[k] -= bend;
  }
  return force;
}

std::vector<Point2> Snake::whole_force(const ImageLandscape* image) const {
  std::vector<Point2> force = internal_force();
  for (size_t i = 0; i < anchors_.size(); ++i) {
    force[i] += anchors_[i].weight * (anchors_[i].target - nodes_[i]);
  }
  if (image != nullptr) {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      force[i] -= options_.image_weight * image->gradient(i, nodes_[i]);
    }
  }
  if (options_.ends == SnakeEnds::kFixed) force.front() = force.back() = Point2::Zero();
  return force;
}

double Snake::strongest_anchor() const {
  double strongest = 0.0;
  for (const SoftAnchor& anchor : anchors_) strongest = std::max(strongest, anchor.weight);
  return strongest;
}

void Snake::factor() {
  if (options_.stepping == SnakeStepping::kExplicit) {
    const double bound = explicit_step_bound(options_, strongest_anchor());
    require(!options_.whole_step || options_.step < bound,
            "snake: explicit step " + shortest_text(options_.step) +
                " is beyond its bound; expected less than 2 damping / (4 tension + 16 rigidity + "
                "anchor) = " +
                shortest_text(bound));
    return;
  }
  const size_t n = nodes_.size();
  const double a = options_.tension;
  const double b = options_.rigidity;
  std::vector<double> h0(n, options_.damping / options_.step), h1(n, 0.0), h2(n, 0.0);
  for (size_t i = 0; i < num_springs(); ++i) {
    h0[i] += a;
    h0[next(i)] += a;
    h1[i] -= a;
  }
  for (size_t i = 0; i < num_bends(); ++i) {
    const size_t j = next(i);
    h0[i] += b;
    h0[j] += 4.0 * b;
    h0[next(j)] += b;
    h1[i] -= 2.0 * b;
    h1[j] -= 2.0 * b;
    h2[i] += b;
  }
  for (size_t i = 0; i < anchors_.size(); ++i) h0[i] += anchors_[i].weight;
  if (options_.ends == SnakeEnds::kFixed) {
    // A fixed end feels no force and moves by nothing: nothing couples to it.
    h0.front() = h0.back() = 1.0;
    h1.front() = h1[n - 2] = h2.front() = h2[n - 3] = 0.0;
  }
  matrix_.factor(std::move(h0), std::move(h1), std::move(h2));
}

// The largest second derivative of P under the nodes, from its gradient half a pixel to each side
// and at the node itself: the landscape may have been made of straight pieces a pixel long.
double Snake::image_curvature(const ImageLandscape& image) const {
  constexpr double kReach = 0.5;  // px
  double largest = 0.0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const Point2 here = image.gradient(i, nodes_[i]);
    for (const Point2& by : {Point2(kReach, 0.0), Point2(0.0, kReach)}) {
      const double ahead = (image.gradient(i, nodes_[i] + by) - here).norm();
      const double behind = (image.gradient(i, nodes_[i] - by) - here).norm();
      largest = std::max({largest, ahead / kReach, behind / kReach});
    }
  }
  // Of a symmetric matrix of two rows the norm is at most this much above that of its columns.
  return std::sqrt(2.0) * largest;
}

int Snake::num_parts(const ImageLandscape* image) const {
  if (options_.stepping == SnakeStepping::kImplicit || options_.whole_step) return 1;
  constexpr double kOfBound = 0.9;
  constexpr double kMost = 1e6;
  const double curvature = image != nullptr ? image_curvature(*image) : 0.0;
  const double bound = kOfBound * explicit_step_bound(options_, strongest_anchor(), curvature);
  return static_cast<int>(std::clamp(std::ceil(options_.step / bound), 1.0, kMost));
}

double Snake::advance(const ImageLandscape* image) {
  const int parts = num_parts(image);
  if (parts == 1) return advance_part(image, 1);
  const std::vector<Point2> before = nodes_;
  for (int part = 0; part < parts; ++part) {
    if (!std::isfinite(advance_part(image, parts))) {
      nodes_ = before;
      return std::numeric_limits<double>::quiet_NaN();
    }
  }
  return largest_move(before, nodes_);
}

double Snake::advance_part(const ImageLandscape* image, int num_parts) {
  const double step = options_.step / num_parts;
  const double cap = options_.step_cap_px / num_parts;
  std::vector<Point2> moves = whole_force(image);
  if (options_.stepping == SnakeStepping::kImplicit) {
    matrix_.solve(moves);
  } else {
    for (Point2& move : moves) move *= step / options_.damping;
  }
  if (!all_finite(moves)) return std::numeric_limits<double>::quiet_NaN();
  double largest = 0.0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const double length = moves[i].norm();
    // The cap tames the explicit image force; a chain without an image needs none.
    if (image != nullptr && length > 0.0) moves[i] *= cap * std::tanh(length / cap) / length;
    nodes_[i] += moves[i];
    largest = std::max(largest, moves[i].norm());
  }
  if (options_.viscosity > 0.0) {
    for (size_t i = 0; i < num_springs(); ++i) {
      const double e = (nodes_[next(i)] - nodes_[i]).norm() - rest_lengths_[i];
      rest_lengths_[i] = std::clamp(rest_lengths_[i] + step * options_.viscosity * e,
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
