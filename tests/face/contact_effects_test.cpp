// Contact: what must not be entered is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "face/energy.h"
#include "face/generic_head.h"
#include "face/jaw.h"
#include "face/simulator.h"

namespace zygoma {
namespace {

std::shared_ptr<const Anatomy> head() {
  static const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 500, .skin_levels = 0, .albedo_size_px = 64}));
  return anatomy;
}

// The head with muscles that shorten more than is good for it.
std::shared_ptr<const Anatomy> head_with_strong(const std::string& prefix, double factor) {
  Anatomy anatomy = *head();
  for (Muscle& muscle : anatomy.muscles) {
    if (!muscle.name.starts_with(prefix)) continue;
    muscle.largest_shortening = std::min(1.0, factor * muscle.largest_shortening);
  }
  return std::make_shared<const Anatomy>(std::move(anatomy));
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
  const auto face = head_with_strong("occipitofrontalis", 2.0);
  // Bone that does not give way at all, as in the paper.
  for (const double slip : {0.0, 0.7}) {
    std::array<double, 2> height{};
    for (const int with : {0, 1}) {
      TissueModel model;
      model.muscles.slip_elsewhere = slip;
      if (with == 1) model.effects.push_back({"skull_contact", {}});
      Simulator simulator(face, model);
      FaceState state = simulator.rest();
      EXPECT_TRUE(simulator.settle(contracted(*face, "occipitofrontalis", 1.0), state).converged);
      height[with] = smallest_height(*face, simulator.lattice(), state);
    }
    EXPECT_LT(height[0], slip == 0.0 ? -0.5 : 0.2) << "the case is not hard any more";
    EXPECT_GT(height[1], slip == 0.0 ? 0.0 : 0.3);
  }
}

// Columns of the exact sensitivities at an equilibrium against central differences.
void expect_exact_sensitivities(Simulator& simulator,
                                const Controls& controls,
                                const FaceState& state,
                                const std::vector<int>& columns) {
  const Sensitivity exact = simulator.surface_sensitivity(controls, state);
  EXPECT_FALSE(exact.damped);
  for (const int column : columns) {
    const bool is_jaw = column == static_cast<int>(controls.contraction.size());
    const double h = 1e-5;  // lips that meet answer to the jaw on a strong curve
    std::array<FaceState, 2> moved{state, state};
    for (const int side : {0, 1}) {
      Controls shifted = controls;
      (is_jaw ? shifted.jaw_rad : shifted.contraction[column]) += side == 0 ? h : -h;
      ASSERT_TRUE(simulator.settle(shifted, moved[side]).converged);
    }
    Eigen::VectorXd difference(exact.mm.rows());
    for (Eigen::Index k = 0; k < difference.size(); ++k) {
      difference[k] =
          (moved[0].positions_mm[k / 3][k % 3] - moved[1].positions_mm[k / 3][k % 3]) / (2 * h);
    }
    EXPECT_LT((difference - exact.mm.col(column)).norm(), 1e-4 * difference.norm()) << column;
  }
}

SettleOptions tight() {
  SettleOptions options;
  options.relative_residual = 1e-10;
  return options;
}

TEST(SkullContact, SensitivitiesMatchCentralDifferencesInContact) {
  TissueModel model;
  model.effects.push_back({"skull_contact", {{"distance_share", 0.9}}});
  Simulator simulator(head(), model, tight());
  Controls controls = contracted(*head(), "occipitofrontalis", 0.6);
  controls.jaw_rad = 0.05;
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls, state).converged);
  ASSERT_LT(smallest_height(*head(), simulator.lattice(), state), 0.85) << "no contact";
  expect_exact_sensitivities(simulator,
                             controls,
                             state,
                             {head()->muscle_index("occipitofrontalis_major_L"),
                              static_cast<int>(controls.contraction.size())});
}

// A head with a muscle that lifts the lower lip, stronger than life.
std::shared_ptr<const Anatomy> pouting_head() {
  static const auto anatomy = [] {
    Anatomy with = *head();
    with.muscles.push_back({"lift", Vec3(0.0, -74.0, 19.3), Vec3(0.0, -54.0, 19.3), 25.0, 0.4});
    return std::make_shared<const Anatomy>(std::move(with));
  }();
  return anatomy;
}

// Smallest height of the rim of the upper lip over the point of the lower that it rests on.
double smallest_gap(const Anatomy& anatomy, const FaceState& state) {
  constexpr double kSamePlaceMm = 0.5;
  const std::vector<Vec3>& rest = anatomy.surface.positions_mm;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t u = 0; u < rest.size(); ++u) {
    for (std::size_t l = 0; l < rest.size(); ++l) {
      if (anatomy.region[u] != Region::kUpperLip || anatomy.region[l] != Region::kLowerLip)
        continue;
      if ((rest[u] - rest[l]).norm() > kSamePlaceMm) continue;
      smallest = std::min(smallest, state.positions_mm[u].y() - state.positions_mm[l].y());
    }
  }
  return smallest;
}

TEST(LipContact, MouthThatClosesStopsWhereTheLipsMeetAndLetsGo) {
  std::array<double, 2> gap{};
  for (const int with : {0, 1}) {
    TissueModel model;
    if (with == 1) model.effects.push_back({"lip_contact", {}});
    Simulator simulator(pouting_head(), model);
    FaceState state = simulator.rest();
    Controls controls = contracted(*pouting_head(), "depressor_labii_inferioris", 1.0);
    controls.jaw_rad = 0.2;
    EXPECT_TRUE(simulator.settle(controls, state).converged);
    EXPECT_GT(smallest_gap(*pouting_head(), state), 5.0);
    // In steps: contact acts where lips meet, not on the way of one that jumps through the other.
    for (const double lift : {0.2, 0.4, 0.6, 0.8, 1.0}) {
      EXPECT_TRUE(simulator.settle(contracted(*pouting_head(), "lift", lift), state).converged);
    }
    gap[with] = smallest_gap(*pouting_head(), state);
    EXPECT_TRUE(simulator.settle(contracted(*pouting_head(), "lift", 0.0), state).converged);
    double away = 0.0;
    for (std::size_t k = 0; k < state.positions_mm.size(); ++k) {
      away = std::max(away, (state.positions_mm[k] - simulator.lattice().rest_mm[k]).norm());
    }
    EXPECT_LT(away, 1e-3);
  }
  EXPECT_LT(gap[0], -5.0) << "the case is not hard any more";
  EXPECT_GT(gap[1], -0.15);
}

// How much deeper than at rest the lips are in the teeth.
double deepest_in_teeth(const Anatomy& anatomy, const FaceState& state) {
  const auto outside = [](const DentalArch& arch, const Vec3& q) {
    const double t = std::max(0.0, (q.z() - arch.front_z_mm) / arch.depth_mm + 1.0);
    const double x = q.x() / arch.half_width_mm;
    return arch.half_width_mm * (std::sqrt(x * x + std::pow(t, 2.5)) - 1.0);
  };
  const Eigen::Isometry3d closed = open_from_closed(anatomy.jaw, state.jaw_rad).inverse();
  double deepest = 0.0;
  for (std::size_t v = 0; v < anatomy.region.size(); ++v) {
    if (anatomy.region[v] != Region::kUpperLip && anatomy.region[v] != Region::kLowerLip) continue;
    for (const bool upper : {true, false}) {
      constexpr double kPastTheEdgeMm = 1.5;
      const DentalArch& arch = upper ? anatomy.teeth->upper : anatomy.teeth->lower;
      const Vec3 q = upper ? state.positions_mm[v] : Vec3(closed * state.positions_mm[v]);
      if ((upper ? 1.0 : -1.0) * (q.y() - arch.edge_y_mm) < kPastTheEdgeMm) continue;
      const double at_rest = std::min(0.0, outside(arch, anatomy.surface.positions_mm[v]));
      deepest = std::max(deepest, at_rest - outside(arch, q));
    }
  }
  return deepest;
}

TEST(TeethContact, LipsDrawnBackStayInFrontOfTheTeethAlsoOfAnOpenJaw) {
  Anatomy large_teeth = *head();
  for (DentalArch* arch : {&large_teeth.teeth->upper, &large_teeth.teeth->lower}) {
    arch->front_z_mm += 2.0;
    arch->half_width_mm += 2.0;
  }
  const auto face = std::make_shared<const Anatomy>(std::move(large_teeth));
  for (const double jaw_rad : {0.0, 0.2}) {
    std::array<double, 2> depth_mm{};
    for (const int with : {0, 1}) {
      TissueModel model;
      if (with == 1) model.effects.push_back({"teeth_contact", {}});
      Simulator simulator(face, model);
      FaceState state = simulator.rest();
      Controls controls = contracted(*face, "depressor_anguli_oris", 1.0);
      controls.jaw_rad = jaw_rad;
      EXPECT_TRUE(simulator.settle(controls, state).converged);
      depth_mm[with] = deepest_in_teeth(*face, state);
    }
    EXPECT_GT(depth_mm[0], 0.3) << "the case is not hard any more";
    EXPECT_LT(depth_mm[1], 0.5 * depth_mm[0]);
  }
}

TEST(TeethContact, FaceWithoutTeethHasNoSuchTerm) {
  Anatomy toothless = *head();
  toothless.teeth.reset();
  TissueModel model;
  model.effects = {{"teeth_contact", {}}};
  EXPECT_TRUE(FaceEnergy(toothless, model).effects().energy().empty());
  EXPECT_EQ(FaceEnergy(*head(), model).effects().energy().size(), 1U);
}

TEST(LipContact, SensitivitiesMatchCentralDifferencesInContact) {
  TissueModel model;
  model.effects.push_back({"lip_contact", {}});
  model.effects.push_back({"teeth_contact", {}});
  Simulator simulator(pouting_head(), model, tight());
  Controls controls = contracted(*pouting_head(), "lift", 0.35);
  controls.contraction[pouting_head()->muscle_index("depressor_anguli_oris_L")] = 0.3;
  controls.jaw_rad = 0.01;
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls, state).converged);
  ASSERT_LT(smallest_gap(*pouting_head(), state), 0.25) << "no contact";
  expect_exact_sensitivities(simulator,
                             controls,
                             state,
                             {pouting_head()->muscle_index("lift"),
                              pouting_head()->muscle_index("depressor_anguli_oris_L"),
                              static_cast<int>(controls.contraction.size())});
}

}  // namespace
}  // namespace zygoma
