#include "retarget/profile.h"

#include <algorithm>

namespace zygoma {

Eigen::VectorXd range_gain(const PerformerProfile& profile, const FaceResponse& face) {
  Eigen::VectorXd gain = Eigen::VectorXd::Ones(face.num_controls());
  for (const auto& [name, range] : profile.range) {
    const auto at = std::find(face.muscles.begin(), face.muscles.end(), name);
    if (at == face.muscles.end() && name != "jaw") continue;
    gain[at - face.muscles.begin()] = range;
  }
  return gain;
}

}  // namespace zygoma
