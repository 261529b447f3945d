#include "face/active_region.h"

#include <gtest/gtest.h>

#include "face/generic_head.h"
#include "face/simulator.h"

namespace zygoma {
namespace {

const std::shared_ptr<const Anatomy>& head() {
  static const auto anatomy = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 420, .skin_levels = 0, .albedo_size_px = 64}));
  return anatomy;
}

Controls with(std::initializer_list<std::pair<const char*, double>> contractions, double jaw_rad) {
  Controls controls{std::vector<double>(head()->muscles.size(), 0.0), jaw_rad};
  for (const auto& [name, value] : contractions) {
    controls.contraction[head()->muscle_index(name)] = value;
  }
  return controls;
}

// Over the surface: deeper down, thin tissue may fold one way or another after different paths.
double largest_distance(const FaceState& a, const FaceState& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < head()->surface.positions_mm.size(); ++k) {
    largest = std::max(largest, (a.positions_mm[k] - b.positions_mm[k]).norm());
  }
  return largest;
}

SettleOptions precise(double still_mm) {
  SettleOptions options;
  options.relative_residual = 1e-7;
  options.max_iterations = 300;
  options.still_mm = still_mm;
  return options;
}

TEST(ActiveRegion, GivesTheResultOfSolvingForEverythingWithinItsTolerance) {
  constexpr double kStillMm = 0.05;
  Simulator whole(head(), {}, precise(0.0));
  Simulator part(head(), {}, precise(kStillMm));
  FaceState expected = whole.rest();
  FaceState state = part.rest();
  double smallest_share = 1.0;
  const std::vector<Controls> play{
      with({{"occipitofrontalis_inner_L", 0.2}}, 0.0),
      with({{"occipitofrontalis_inner_L", 0.6}, {"occipitofrontalis_inner_R", 0.6}}, 0.0),
      with({{"occipitofrontalis_inner_L", 0.3}, {"corrugator_supercilii_R", 0.5}}, 0.0),
      with({{"corrugator_supercilii_R", 0.5}, {"zygomaticus_major_L", 0.3}}, 0.0),
      with({{"zygomaticus_major_L", 0.5}}, 0.1),
      with({}, 0.2),
      with({}, 0.0),
  };
  for (const Controls& controls : play) {
    ASSERT_TRUE(whole.settle(controls, expected).converged);
    const SettleReport report = part.settle(controls, state);
    ASSERT_TRUE(report.converged);
    smallest_share = std::min(smallest_share, report.moving_share);
    EXPECT_LT(largest_distance(state, expected), kStillMm);
  }
  EXPECT_LT(smallest_share, 0.5) << "brows move, the chin need not be solved for";
}

TEST(ActiveRegion, NothingMovesNothingIsSolvedFor) {
  Simulator face(head(), {}, precise(0.01));
  FaceState state = face.rest();
  const SettleReport report = face.settle(with({}, 0.0), state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.moving_share, 0.0);
  EXPECT_EQ(state.positions_mm, face.rest().positions_mm);
}

TEST(ActiveRegion, ZeroToleranceIsSolvingForEverything) {
  Simulator face(head(), {}, precise(0.0));
  FaceState state = face.rest();
  EXPECT_EQ(face.settle(with({{"zygomaticus_major_L", 0.1}}, 0.0), state).moving_share, 1.0);
}

}  // namespace
}  // namespace zygoma
