// Distances from polylines.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

inline double distance_to_line(const Point2& x, const std::vector<Point2>& line) {
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Point2 along = line[i + 1] - line[i];
    const double length2 = along.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((x - line[i]).dot(along) / length2, 0.0, 1.0) : 0.0;
    least = std::min(least, (x - line[i] - t * along).norm());
  }
  return least;
}

}  // namespace zygoma
