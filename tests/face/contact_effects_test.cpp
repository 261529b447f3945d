// Contact: what must not be entered is not.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "face/generic_head.h"
#include "face/simulator.h"

namespace zygoma {
namespace {

std::shared_ptr<const Anatomy> head() {
  static const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 500, .skin_levels = 0, .albedo_size_px = 64}));
  return anatomy;
}

Controls contracted(const Anatomy& anatomy, const std::string& prefix, double contraction) {
  Controls controls{std::vector<double>(anatomy.muscles.size(), 0.0), 0.0};
  for (std::size_t m = 0; m < anatomy.muscles.size(); ++m) {
    if (anatomy.muscles[m].name.starts_with(prefix)) controls.contraction[m] = contraction;
  }
  return controls;
}

// The fascia of the whole face over the bone below it, in shares of the distance at rest.
double smallest_height(const Anatomy& anatomy, const Lattice& lattice, const FaceState& state) {
  std::vector<Vec3> normal(lattice.columns.size(), Vec3::Zero());
  std::vector<Vec3> normal_at_rest = normal;
  const auto area = [&](const std::vector<Vec3>& x, const Triangle& t) -> Vec3 {
    const auto bone = [&](int v) { return x[lattice.columns[v].bone()]; };
    return (bone(t[1]) - bone(t[0])).cross(bone(t[2]) - bone(t[0]));
  };
  for (const Triangle& t : anatomy.surface.triangles) {
    for (const int v : t) {
      normal[v] += area(state.positions_mm, t);
      normal_at_rest[v] += area(lattice.rest_mm, t);
    }
  }
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < lattice.columns.size(); ++v) {
    const Column& column = lattice.columns[v];
    if (column.is_thin() || anatomy.region[v] != Region::kFace) continue;
    const auto height = [&](const std::vector<Vec3>& x, const Vec3& n) {
      return (x[column.fascia()] - x[column.bone()]).dot(n.normalized());
    };
    smallest = std::min(
        smallest,
        height(state.positions_mm, normal[v]) / height(lattice.rest_mm, normal_at_rest[v]));
  }
  return smallest;
}

TEST(SkullContact, FasciaStaysOutsideAConvexForehead) {
  // Bone that does not give way at all, as in the paper.
  for (const double slip : {0.0, 0.7}) {
    std::array<double, 2> height{};
    for (const int with : {0, 1}) {
      TissueModel model;
      model.muscles.slip_elsewhere = slip;
      if (with == 1) model.effects.push_back({"skull_contact", {}});
      Simulator simulator(head(), model);
      FaceState state = simulator.rest();
      EXPECT_TRUE(simulator.settle(contracted(*head(), "occipitofrontalis", 1.0), state).converged);
      height[with] = smallest_height(*head(), simulator.lattice(), state);
    }
    EXPECT_LT(height[0], slip == 0.0 ? -0.5 : 0.2) << "the case is not hard any more";
    EXPECT_GT(height[1], slip == 0.0 ? 0.0 : 0.3);
  }
}

TEST(SkullContact, SensitivitiesMatchCentralDifferencesInContact) {
  TissueModel model;
  model.effects.push_back({"skull_contact", {{"distance_share", 0.9}}});
  SettleOptions tight;
  tight.relative_residual = 1e-11;
  Simulator simulator(head(), model, tight);
  Controls controls = contracted(*head(), "occipitofrontalis", 0.5);
  controls.jaw_rad = 0.05;
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls, state).converged);
  ASSERT_LT(smallest_height(*head(), simulator.lattice(), state), 0.85) << "no contact";
  const Sensitivity exact = simulator.surface_sensitivity(controls, state);
  EXPECT_FALSE(exact.damped);
  const int jaw = static_cast<int>(head()->muscles.size());
  for (const int control : {head()->muscle_index("occipitofrontalis_major_L"), jaw}) {
    const double h = 1e-4;
    std::array<FaceState, 2> moved{state, state};
    for (const int side : {0, 1}) {
      Controls shifted = controls;
      double& value = control == jaw ? shifted.jaw_rad : shifted.contraction[control];
      value += side == 0 ? h : -h;
      ASSERT_TRUE(simulator.settle(shifted, moved[side]).converged);
    }
    Eigen::VectorXd difference(exact.mm.rows());
    for (Eigen::Index k = 0; k < difference.size(); ++k) {
      difference[k] =
          (moved[0].positions_mm[k / 3][k % 3] - moved[1].positions_mm[k / 3][k % 3]) / (2 * h);
    }
    EXPECT_LT((difference - exact.mm.col(control)).norm(), 1e-4 * difference.norm()) << control;
  }
}

}  // namespace
}  // namespace zygoma
