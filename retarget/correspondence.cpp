#include "retarget/correspondence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include "src/base/check.h"

namespace zygoma {
namespace {

std::vector<double> arc_length_from_start(const std::vector<Point2>& polyline) {
  std::vector<double> arc(polyline.size(), 0.0);
  for (std::size_t i = 1; i < polyline.size(); ++i) {
    arc[i] = arc[i - 1] + (polyline[i] - polyline[i - 1]).norm();
  }
  return arc;
}

// The segment that holds an arc length, preferring segments of non-zero length.
std::size_t segment_at(const std::vector<double>& arc, double length) {
  const auto above = std::upper_bound(arc.begin() + 1, arc.end() - 1, length);
  std::size_t segment = static_cast<std::size_t>(above - arc.begin()) - 1;
  while (segment > 0 && arc[segment + 1] <= arc[segment]) --segment;
  return segment;
}

}  // namespace

int StackedContours::num_visible() const {
  return static_cast<int>(
      std::count_if(confidence.begin(), confidence.end(), [](double c) { return c > 0.0; }));
}

Point2 StackedContours::mean(int contour) const {
  return nodes.middleCols(node_begin(contour), num_nodes(contour)).rowwise().mean();
}

void resample_by_arc_length(const std::vector<Point2>& polyline,
                            const std::vector<Point2>& velocity,
                            std::vector<Point2>& points,
                            std::vector<Point2>& point_velocity) {
  assert(polyline.size() >= 2 && points.size() >= 2 && velocity.size() == polyline.size());
  const std::vector<double> arc = arc_length_from_start(polyline);
  std::vector<double> arc_rate(polyline.size(), 0.0);
  for (std::size_t i = 1; i < polyline.size(); ++i) {
    const Point2 edge = polyline[i] - polyline[i - 1];
    const double length = edge.norm();
    const double rate = length > 0.0 ? edge.dot(velocity[i] - velocity[i - 1]) / length : 0.0;
    arc_rate[i] = arc_rate[i - 1] + rate;
  }
  point_velocity.assign(points.size(), Point2::Zero());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(points.size() - 1);
    const std::size_t s = segment_at(arc, share * arc.back());
    const double length = arc[s + 1] - arc[s];
    const double t =
        length > 0.0 ? std::clamp((share * arc.back() - arc[s]) / length, 0.0, 1.0) : 0;
    const Point2 edge = polyline[s + 1] - polyline[s];
    points[k] = polyline[s] + t * edge;
    point_velocity[k] = velocity[s] + t * (velocity[s + 1] - velocity[s]);
    const bool is_end = k == 0 || k + 1 == points.size();
    if (length > 0.0 && !is_end) {
      const double length_rate = arc_rate[s + 1] - arc_rate[s];
      const double t_rate = (share * arc_rate.back() - arc_rate[s] - t * length_rate) / length;
      point_velocity[k] += t_rate * edge;
    }
  }
}

std::vector<Point2> resample_by_arc_length(const std::vector<Point2>& polyline, int num_points) {
  std::vector<Point2> points(static_cast<std::size_t>(num_points));
  std::vector<Point2> ignored;
  resample_by_arc_length(
      polyline, std::vector<Point2>(polyline.size(), Point2::Zero()), points, ignored);
  return points;
}

StackedContours stack_contours(const ContourSet& set) {
  StackedContours stack;
  for (int c = 0; c < kNumContours; ++c) {
    const Contour* contour = set.visible(kFeatureSchema[static_cast<std::size_t>(c)].name);
    if (contour == nullptr || contour->points_px.size() < 2) continue;
    const bool finite = std::isfinite(contour->confidence) &&
                        std::all_of(contour->points_px.begin(),
                                    contour->points_px.end(),
                                    [](const Point2& p) { return p.allFinite(); });
    require(finite,
            "frame " + std::to_string(set.frame_index) + ": contour " + contour->name +
                " holds a number that is not finite; expected finite pixels and a confidence in "
                "[0, 1]");
    const std::vector<Point2> nodes = resample_by_arc_length(contour->points_px, num_nodes(c));
    for (int k = 0; k < num_nodes(c); ++k) {
      stack.nodes.col(node_begin(c) + k) = nodes[static_cast<std::size_t>(k)];
    }
    stack.confidence[static_cast<std::size_t>(c)] = std::clamp(contour->confidence, 0.0, 1.0);
  }
  return stack;
}

}  // namespace zygoma
