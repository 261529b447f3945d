#include "retarget/estimate.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace zygoma {
namespace {

struct ReadingRule {
  std::string_view muscle;
  int contour;
  int node;
};

// P-67 to P-71.
constexpr std::array<ReadingRule, 10> kReadingRules{{
    {"zygomaticus_major_L", kUpperLipContour, last_node(kUpperLipContour)},
    {"zygomaticus_major_R", kUpperLipContour, first_node(kUpperLipContour)},
    {"levator_labii_superioris_alaeque_nasi_L", kFurrowLeftContour, first_node(kFurrowLeftContour)},
    {"levator_labii_superioris_alaeque_nasi_R",
     kFurrowRightContour,
     first_node(kFurrowRightContour)},
    {"occipitofrontalis_inner_L", kBrowLeftContour, first_node(kBrowLeftContour)},
    {"occipitofrontalis_inner_R", kBrowRightContour, first_node(kBrowRightContour)},
    {"occipitofrontalis_major_L", kBrowLeftContour, centre_node(kBrowLeftContour)},
    {"occipitofrontalis_major_R", kBrowRightContour, centre_node(kBrowRightContour)},
    {"occipitofrontalis_outer_L", kBrowLeftContour, last_node(kBrowLeftContour)},
    {"occipitofrontalis_outer_R", kBrowRightContour, last_node(kBrowRightContour)},
}};

// A range below this is the model's way of saying that the point does not show the muscle.
constexpr double kLeastRange_mm = 0.5;

double share_of_range(const Point2& displacement, const Point2& full) {
  const double range = full.norm();
  if (range < kLeastRange_mm) return 0.0;
  return std::clamp(displacement.dot(full) / (range * range), 0.0, 1.0);
}

Point2 mean_displacement(const FaceResponse& response, int contour, const Eigen::VectorXd& u) {
  Point2 sum = Point2::Zero();
  for (int k = node_begin(contour); k < node_begin(contour + 1); ++k) {
    sum += response.displacement(k, u.data());
  }
  return sum / num_nodes(contour);
}

bool usable(const Displacements& observed, const FaceResponse& response, int contour) {
  const auto c = static_cast<std::size_t>(contour);
  return observed.usable[c] && response.has_contour[c];
}

}  // namespace

Eigen::VectorXd estimate_controls(const Displacements& observed,
                                  const FaceResponse& response,
                                  const Eigen::VectorXd* fallback) {
  const int n = response.num_muscles();
  Eigen::VectorXd controls = Eigen::VectorXd::Zero(n + 1);
  if (fallback != nullptr) controls = *fallback;

  // P-72: the jaw.
  Eigen::VectorXd jaw_alone = Eigen::VectorXd::Zero(n + 1);
  if (usable(observed, response, kChinBossContour)) {
    const Point2 chin =
        observed.mm.middleCols(node_begin(kChinBossContour), num_nodes(kChinBossContour))
            .rowwise()
            .mean();
    jaw_alone[n] = 1.0;
    controls[n] = share_of_range(chin, mean_displacement(response, kChinBossContour, jaw_alone));
  }
  jaw_alone[n] = controls[n];

  for (int i = 0; i < n; ++i) {
    const auto& name = response.muscles[static_cast<std::size_t>(i)];
    const auto rule = std::find_if(kReadingRules.begin(),
                                   kReadingRules.end(),
                                   [&](const ReadingRule& r) { return r.muscle == name; });
    if (rule == kReadingRules.end()) continue;
    if (!usable(observed, response, rule->contour)) continue;
    Eigen::VectorXd full = Eigen::VectorXd::Zero(n + 1);
    full[i] = 1.0;
    const Point2 displacement =
        observed.mm.col(rule->node) - response.displacement(rule->node, jaw_alone.data());
    controls[i] = share_of_range(displacement, response.displacement(rule->node, full.data()));
  }
  return controls;
}

}  // namespace zygoma
