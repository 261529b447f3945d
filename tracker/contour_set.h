// What the tracker says about one frame: the contours in the image, each with a confidence.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace zygoma {

using Point2 = Eigen::Vector2d;  // pixels, x right, y down

struct Contour {
  std::string name;               // one of feature_schema()
  std::vector<Point2> points_px;  // in the order of the schema; empty when the contour is lost
  double confidence = 0.0;        // [0, 1]; 0 exactly when the contour is lost
  bool locked = false;            // a pin or spring holds it

  bool lost() const { return points_px.empty(); }
  bool operator==(const Contour&) const = default;
};

struct ContourSet {
  int frame_index = 0;
  double time_s = 0.0;
  std::vector<Contour> contours;  // empty, or all of feature_schema() in its order

  // The contour of that name, or nullptr if it is missing or lost.
  const Contour* visible(std::string_view name) const {
    for (const Contour& contour : contours) {
      if (contour.name == name) return contour.lost() ? nullptr : &contour;
    }
    return nullptr;
  }
  bool operator==(const ContourSet&) const = default;
};

}  // namespace zygoma
