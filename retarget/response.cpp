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
                             "depressor_labii_inferioris",
                             "orbicularis_oculi_palpebral",
                             "levator_palpebrae_superioris"}) {
      both.push_back(std::string(name) + "_L");
      both.push_back(std::string(name) + "_R");
    }
    return both;
  }();
  return names;
}

bool moves_lid(std::string_view muscle) {
  return muscle.starts_with("orbicularis_oculi_palpebral") ||
         muscle.starts_with("levator_palpebrae_superioris");
}

FaceResponse FaceResponse::zero(const std::vector<std::string>& muscles) {
  FaceResponse response;
  response.muscles = muscles;
  const auto n = static_cast<Eigen::Index>(muscles.size());
  response.linear_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n + 1);
  response.quadratic_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n + 1);
  response.cubic_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, n + 1);
  response.pair_mm = Eigen::MatrixXd::Zero(2 * kNumNodes, 0);
  return response;
}

FaceResponse FaceResponse::linearised() const {
  constexpr double kHalf = 0.5;
  FaceResponse result = *this;
  result.linear_mm += kHalf * (quadratic_mm + kHalf * cubic_mm);
  result.quadratic_mm.setZero();
  result.cubic_mm.setZero();
  result.pairs.clear();
  result.pair_mm.resize(2 * kNumNodes, 0);
  return result;
}

FaceResponse FaceResponse::scaled(const Eigen::VectorXd& gain) const {
  FaceResponse result = *this;
  result.linear_mm *= gain.asDiagonal();
  result.quadratic_mm *= gain.asDiagonal();
  result.cubic_mm *= gain.asDiagonal();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    result.pair_mm.col(static_cast<Eigen::Index>(p)) *=
        gain[pairs[p].first] * gain[pairs[p].second];
  }
  return result;
}

void FaceResponse::displace(const Eigen::VectorXd& controls,
                            Eigen::VectorXd& displacement_mm,
                            Eigen::MatrixXd* slope_mm) const {
  displacement_mm.setZero(linear_mm.rows());
  if (slope_mm != nullptr) *slope_mm = linear_mm;
  for (Eigen::Index i = 0; i < controls.size(); ++i) {
    const double u = controls[i];
    if (u == 0.0) continue;  // most, most of the time
    const auto l = linear_mm.col(i);
    const auto q = quadratic_mm.col(i);
    const auto r = cubic_mm.col(i);
    displacement_mm += u * (l + u * (q + u * r));
    if (slope_mm != nullptr) slope_mm->col(i) += u * (2.0 * q + 3.0 * u * r);
  }
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [a, b] = pairs[p];
    if (controls[a] == 0.0 && controls[b] == 0.0) continue;
    const auto x = pair_mm.col(static_cast<Eigen::Index>(p));
    displacement_mm += controls[a] * controls[b] * x;
    if (slope_mm == nullptr) continue;
    slope_mm->col(a) += controls[b] * x;
    slope_mm->col(b) += controls[a] * x;
  }
}

Point2 FaceResponse::displacement(int node, const double* controls) const {
  Point2 sum = Point2::Zero();
  for (int i = 0; i < num_controls(); ++i) {
    const double u = controls[i];
    sum += u *
           (linear_mm.col(i).segment<2>(2 * node) + u * (quadratic_mm.col(i).segment<2>(2 * node) +
                                                         u * cubic_mm.col(i).segment<2>(2 * node)));
  }
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [a, b] = pairs[p];
    sum +=
        controls[a] * controls[b] * pair_mm.col(static_cast<Eigen::Index>(p)).segment<2>(2 * node);
  }
  return sum;
}

}  // namespace zygoma
