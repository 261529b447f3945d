// Joins what the tracker saw and what the face can do: by contour name and by arc length.
//
// Both sides are stacked into one row of nodes, contour after contour in the order of
// feature_schema.h, every contour resampled to its schema's node count at even arc length. Node k
// of the stack of a frame is then compared with node k of the stack of the face model. Only
// displacements from the neutral are compared, never positions, so that the identity of the
// performer does not matter to first order.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "tracker/contour_set.h"
#include "tracker/feature_schema.h"

namespace zygoma {

inline constexpr int kNumContours = static_cast<int>(kFeatureSchema.size());

// First node of each contour in the stack; the last entry is the number of nodes.
inline constexpr std::array<int, kNumContours + 1> kNodeBegin = [] {
  std::array<int, kNumContours + 1> begin{};
  for (int i = 0; i < kNumContours; ++i) {
    begin[static_cast<std::size_t>(i) + 1] =
        begin[static_cast<std::size_t>(i)] + kFeatureSchema[static_cast<std::size_t>(i)].num_nodes;
  }
  return begin;
}();
inline constexpr int kNumNodes = kNodeBegin[kNumContours];

// Place among these contours; -1 for any other name.
constexpr int contour_index(std::string_view name) {
  for (int i = 0; i < kNumContours; ++i) {
    if (kFeatureSchema[static_cast<std::size_t>(i)].name == name) return i;
  }
  return -1;
}
inline constexpr int kBrowLeftContour = contour_index("brow_left");
inline constexpr int kBrowRightContour = contour_index("brow_right");
inline constexpr int kFurrowLeftContour = contour_index("furrow_left");
inline constexpr int kFurrowRightContour = contour_index("furrow_right");
inline constexpr int kNoseTipContour = contour_index("nose_tip");
inline constexpr int kUpperLipContour = contour_index("upper_lip");
inline constexpr int kLowerLipContour = contour_index("lower_lip");
inline constexpr int kChinBossContour = contour_index("chin_boss");
inline constexpr int kHairlineContour = contour_index("hairline");

inline constexpr int kEyelidLeftContour = contour_index("eyelid_left");
inline constexpr int kEyelidRightContour = contour_index("eyelid_right");

// Lids: rims of the eyes from corner to corner. The corners are fixed to the skull; between them a
// lid goes where blinks take it.
constexpr bool is_eyelid(int contour) {
  return kFeatureSchema[static_cast<std::size_t>(contour)].name.starts_with("eyelid_");
}

constexpr int node_begin(int contour) { return kNodeBegin[static_cast<std::size_t>(contour)]; }
constexpr int num_nodes(int contour) { return node_begin(contour + 1) - node_begin(contour); }
constexpr int first_node(int contour) { return node_begin(contour); }
constexpr int centre_node(int contour) { return node_begin(contour) + num_nodes(contour) / 2; }
constexpr int last_node(int contour) { return node_begin(contour + 1) - 1; }

using NodeStack = Eigen::Matrix<double, 2, kNumNodes>;

// One frame as the estimator sees it: nodes of lost contours are zero, their confidence is 0.
struct StackedContours {
  NodeStack nodes = NodeStack::Zero();
  std::array<double, kNumContours> confidence{};

  bool visible(int contour) const { return confidence[static_cast<std::size_t>(contour)] > 0.0; }
  int num_visible() const;
  Point2 mean(int contour) const;
};

// Points at even arc length along a polyline of at least two points, both ends kept.
std::vector<Point2> resample_by_arc_length(const std::vector<Point2>& polyline, int num_points);

// The same, together with the derivative of the result along given velocities of the points.
void resample_by_arc_length(const std::vector<Point2>& polyline,
                            const std::vector<Point2>& velocity,
                            std::vector<Point2>& points,
                            std::vector<Point2>& point_velocity);

// Throws InputError naming frame and contour when a point or confidence is not finite.
StackedContours stack_contours(const ContourSet& set);

}  // namespace zygoma
