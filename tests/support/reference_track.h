// Tracks of another tracker that real clips are held against: the 68 points of Sagonas et al.
// (300-W), numbered from 0: 36..41 the subject's right eye, 42..47 the left one, 48 and 54 the
// right and the left corner of the mouth, 48..54 the upper border of the lips, 54..59 the lower
// one.
#pragma once

#include <Eigen/Core>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/src/scratch_folder.h"
#include "tracker/contour_set.h"

namespace zygoma {

using ReferencePoints = std::vector<Point2>;  // px

// By frame.
inline std::map<int, ReferencePoints> read_reference(const std::string& path) {
  std::istringstream lines(bytes_of(path));
  std::map<int, ReferencePoints> frames;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<double> numbers;
    for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
    if (numbers.size() != 2 + 2 * 68) continue;
    ReferencePoints& points = frames[static_cast<int>(numbers[0])];
    for (size_t i = 0; i < 68; ++i) points.emplace_back(numbers[2 + 2 * i], numbers[3 + 2 * i]);
  }
  return frames;
}

inline Point2 mean_of(const ReferencePoints& points, size_t first, size_t last) {
  Point2 sum(0.0, 0.0);
  for (size_t i = first; i <= last; ++i) sum += points[i];
  return sum / static_cast<double>(last - first + 1);
}

}  // namespace zygoma
