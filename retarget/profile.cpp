#include "retarget/profile.h"

#include "src/base/names.h"

namespace zygoma {

Eigen::VectorXd range_gain(const PerformerProfile& profile, const FaceResponse& face) {
  Eigen::VectorXd gain = Eigen::VectorXd::Ones(face.num_controls());
  for (const auto& [name, range] : profile.range) {
    const int place = name == "jaw" ? face.num_muscles() : find_name(face.muscles, name);
    if (place >= 0) gain[place] = range;
  }
  return gain;
}

}  // namespace zygoma
