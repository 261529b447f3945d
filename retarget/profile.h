// What is known of a performer beyond one clip: the face at rest and the range of motion. Kept in a
// file (src/io/profile_file.h) and used again for every clip of the same person, who then need not
// be at rest anywhere in it, and whose full strength is 1 in all of them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "retarget/calibration.h"
#include "retarget/response.h"

namespace zygoma {

struct PerformerProfile {
  Neutral neutral;  // in pixels of the clip it was taken from
  // Full strength of each control as a multiple of the model's, muscles by name and "jaw"; controls
  // that are not named have 1. [kLeastRange, kLargestRange]
  std::vector<std::pair<std::string, double>> range;

  static constexpr double kLeastRange = 0.25;
  static constexpr double kLargestRange = 3.0;
};

// The range in the order of the controls of a face.
Eigen::VectorXd range_gain(const PerformerProfile& profile, const FaceResponse& face);

}  // namespace zygoma
