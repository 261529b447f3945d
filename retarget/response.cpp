#include "retarget/response.h"

namespace zygoma {

const std::vector<std::string>& observable_muscles() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> both;
    for (const char* name : {"zygomaticus_major",
                             "levator_labii_superioris_alaeque_nasi",
                             "levator_labii_superioris",
                             "occipitofrontalis_inner",
                             "occipitofrontalis_major",
                             "occipitofrontalis_outer",
                             "corrugator_supercilii",
                             "depressor_anguli_oris",
                             "depressor_labii_inferioris"}) {
      both.push_back(std::string(name) + "_L");
      both.push_back(std::string(name) + "_R");
    }
    return both;
  }();
  return names;
}

FaceResponse FaceResponse::zero(const std::vector<std::string>& muscles) {
  FaceResponse response;
  response.muscles = muscles;
  const auto n = static_cast<Eigen::Index>(muscles.size());
  response.linear_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n + 1);
  response.quadratic_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n + 1);
  response.jaw_cubic_mm = Eigen::VectorXd::Zero(2 * kNumNodes);
  response.jaw_cross_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n);
  return response;
}

Point2 FaceResponse::displacement(int node,
                                  const double* controls,
                                  Eigen::Matrix<double, 2, Eigen::Dynamic>* jacobian) const {
  const int n = num_muscles();
  const double jaw = controls[n];
  Point2 sum = Point2::Zero();
  Point2 cross = Point2::Zero();
  for (int i = 0; i <= n; ++i) {
    const double u = controls[i];
    const auto l = linear_mm.col(i).segment<2>(2 * node);
    const auto q = quadratic_mm.col(i).segment<2>(2 * node);
    sum += u * (l + u * q);
    if (i < n) cross += u * jaw_cross_mm.col(i).segment<2>(2 * node);
    if (jacobian != nullptr) {
      jacobian->col(i) = l + 2.0 * u * q;
      if (i < n) jacobian->col(i) += jaw * jaw_cross_mm.col(i).segment<2>(2 * node);
    }
  }
  const auto r = jaw_cubic_mm.segment<2>(2 * node);
  if (jacobian != nullptr) jacobian->col(n) += 3.0 * jaw * jaw * r + cross;
  return sum + jaw * cross + jaw * jaw * jaw * r;
}

Point2 FaceResponse::yaw_motion(int node) const {
  const Point2 p = rest_mm.col(node);
  const double z = rest_depth_mm[node];
  const double magnify = viewing_distance_mm / (viewing_distance_mm - z);
  // (x, z) -> (x + z yaw, z - x yaw), seen with perspective.
  return magnify * Point2(z, 0.0) - p * (magnify / viewing_distance_mm) * (p.x() / magnify);
}

Point2 FaceResponse::pitch_motion(int node) const {
  const Point2 p = rest_mm.col(node);
  const double z = rest_depth_mm[node];
  const double magnify = viewing_distance_mm / (viewing_distance_mm - z);
  // (y, z) -> (y + z pitch, z - y pitch) with y down.
  return magnify * Point2(0.0, z) - p * (magnify / viewing_distance_mm) * (p.y() / magnify);
}

}  // namespace zygoma
