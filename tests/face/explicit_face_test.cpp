#include "face/explicit_face.h"

#include <gtest/gtest.h>

#include "face/simulator.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

std::shared_ptr<const Anatomy> coarse_patch() {
  test_support::FacePatchOptions options;
  options.half_columns = 8;
  options.row_mm = 11.0;
  options.rows_below_mouth = 4;
  options.rows_above_mouth = 12;
  return test_support::shared_face_patch(options);
}

TEST(ExplicitFace, ComesToTheEquilibriumOfTheSameEnergy) {
  const auto anatomy = coarse_patch();
  SettleOptions explicitly;
  explicitly.solver = Solver::kExplicit;
  for (const bool volume : {false, true}) {
    TissueModel tissue;
    if (!volume) tissue.effects.clear();
    tissue.effects.push_back({"inertia", {{"damping_per_s", 60.0}}});
    Simulator in_time(anatomy, tissue, explicitly);
    tissue.effects.pop_back();
    Simulator settled(anatomy, tissue);
    FaceState state = in_time.rest();
    FaceState expected = settled.rest();
    Controls controls{std::vector<double>(anatomy->muscles.size(), 0.0), 0.0};
    double largest = 0.0;
    for (int frame = 1; frame <= 40; ++frame) {
      controls.contraction[anatomy->muscle_index("zygomaticus_major_L")] =
          0.3 * std::min(1.0, frame / 10.0);
      const SettleReport report = in_time.advance(controls, 1.0 / 60.0, state);
      ASSERT_TRUE(report.converged);
      ASSERT_EQ(report.restores, 0);
      ASSERT_GT(report.substeps, 0);
      ASSERT_GT(report.stable_step_s, 0.0);
      settled.settle(controls, expected);
    }
    for (std::size_t k = 0; k < state.positions_mm.size(); ++k) {
      largest = std::max(largest, (state.positions_mm[k] - expected.positions_mm[k]).norm());
    }
    EXPECT_LT(largest, 0.02) << (volume ? "with volume" : "springs only");
    EXPECT_NEAR(state.time_s, 40.0 / 60.0, 1e-12);
  }
}

TEST(ExplicitFace, StaysPutAtRest) {
  const auto anatomy = coarse_patch();
  SettleOptions explicitly;
  explicitly.solver = Solver::kExplicit;
  Simulator face(anatomy, {}, explicitly);
  FaceState state = face.rest();
  const Controls none{std::vector<double>(anatomy->muscles.size(), 0.0), 0.0};
  for (int frame = 0; frame < 3; ++frame) face.advance(none, 1.0 / 60.0, state);
  for (std::size_t k = 0; k < state.positions_mm.size(); ++k) {
    ASSERT_LT((state.positions_mm[k] - face.rest().positions_mm[k]).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace zygoma
