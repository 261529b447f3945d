#include "face/simulator.h"

#include <gtest/gtest.h>

#include <limits>

#include "face/jaw.h"
#include "face/lattice.h"
#include "face/muscle_field.h"
#include "src/base/check.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::make_face_patch;
using test_support::nearest_vertex;
using test_support::shared_face_patch;

FacePatchOptions coarse() {
  FacePatchOptions options;
  options.half_columns = 8;
  options.row_mm = 11.0;
  options.rows_below_mouth = 4;
  options.rows_above_mouth = 12;
  return options;
}

Controls at_rest(const Anatomy& anatomy) {
  return {std::vector<double>(anatomy.muscles.size(), 0.0), 0.0};
}

Controls with(const Anatomy& anatomy, const std::string& muscle, double left, double right) {
  Controls controls = at_rest(anatomy);
  controls.contraction[anatomy.muscle_index(muscle + "_L")] = left;
  controls.contraction[anatomy.muscle_index(muscle + "_R")] = right;
  return controls;
}

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

TEST(Lattice, EveryPrismHasVolumeAtRestAlsoUnderARidge) {
  Anatomy anatomy = make_face_patch(coarse());
  // A sharp ridge across the forehead, higher than it is wide.
  for (Vec3& p : anatomy.surface.positions_mm) {
    p.z() += 18.0 * std::exp(-std::pow((p.y() - 34.0) / 7.0, 2));
  }
  const Lattice lattice = make_lattice(anatomy);
  for (const Prism& prism : lattice.prisms) ASSERT_GT(prism.rest_mm3, 0.0);
}

TEST(Lattice, RejectsWhatCannotCarryTissue) {
  Anatomy anatomy = make_face_patch(coarse());
  anatomy.surface.positions_mm[7].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make_lattice(anatomy), InputError);
  anatomy = make_face_patch(coarse());
  anatomy.tissue_depth_mm[3] = 0.0;
  EXPECT_THROW(make_lattice(anatomy), InputError);
}

TEST(Jaw, ClosedIsIdentityAndOpeningMovesTheChinDownAndBack) {
  const Jaw jaw;
  EXPECT_EQ(open_from_closed(jaw, 0.0).matrix(), Eigen::Isometry3d::Identity().matrix());
  const Vec3 chin(0.0, -118.0, 0.0);
  const Vec3 open = open_from_closed(jaw, 0.35) * chin;
  EXPECT_LT(open.y(), chin.y() - 20.0);
  EXPECT_LT(open.z(), chin.z() - 10.0);
  const double h = 1e-6;
  const Vec3 rate =
      (open_from_closed(jaw, 0.2 + h) * chin - open_from_closed(jaw, 0.2 - h) * chin) / (2 * h);
  EXPECT_LT((rate - opening_rate(jaw, 0.2, chin)).norm(), 1e-6);
}

TEST(MuscleField, DistanceOnAFlatSheetIsEuclidean) {
  SurfaceMesh sheet;
  const int n = 15;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) sheet.positions_mm.push_back({1.0 * i, 1.1 * j, 0.0});
  }
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i;
      sheet.triangles.push_back({a, a + 1, a + n + 1});
      sheet.triangles.push_back({a, a + n + 1, a + n});
    }
  }
  const Vec3 from = sheet.positions_mm[7 * n + 7];
  const std::vector<double> distance = distance_along(sheet, from, 100.0);
  for (std::size_t v = 0; v < distance.size(); ++v) {
    EXPECT_NEAR(distance[v], (sheet.positions_mm[v] - from).norm(), 0.02 * distance[v] + 1e-9);
  }
}

TEST(MuscleField, UpperLipMuscleLeavesTheLowerLipAlone) {
  const Anatomy anatomy = make_face_patch();
  const MuscleField field = make_muscle_field(anatomy, make_lattice(anatomy));
  // At the corner of the mouth the lips are one.
  const auto is_middle = [&](int column) {
    return std::abs(anatomy.surface.positions_mm[column].x()) < 14.0;
  };
  bool reaches_upper = false;
  for (const MusclePull& pull : field.pulls[anatomy.muscle_index("levator_labii_superioris_L")]) {
    EXPECT_FALSE(is_middle(pull.column) && anatomy.region[pull.column] == Region::kLowerLip);
    reaches_upper = reaches_upper || anatomy.region[pull.column] == Region::kUpperLip;
  }
  EXPECT_TRUE(reaches_upper);
  for (const MusclePull& pull : field.pulls[anatomy.muscle_index("depressor_labii_inferioris_L")]) {
    EXPECT_FALSE(is_middle(pull.column) && anatomy.region[pull.column] == Region::kUpperLip);
  }
}

TEST(MuscleField, RejectsAMuscleThatCannotPull) {
  Anatomy anatomy = make_face_patch(coarse());
  const Lattice lattice = make_lattice(anatomy);
  const Muscle good = anatomy.muscles[0];
  anatomy.muscles[0].emergence_mm = good.attachment_mm;
  EXPECT_THROW(make_muscle_field(anatomy, lattice), InputError);
  anatomy.muscles[0] = good;
  anatomy.muscles[0].radius_mm = 0.0;
  EXPECT_THROW(make_muscle_field(anatomy, lattice), InputError);
}

TEST(Simulator, NoInputGivesTheMeshBitForBit) {
  const auto anatomy = shared_face_patch(coarse());
  Simulator simulator(anatomy);
  FaceState state = simulator.rest();
  const SettleReport report = simulator.settle(at_rest(*anatomy), state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(state.positions_mm, simulator.rest().positions_mm);
  for (std::size_t v = 0; v < anatomy->surface.positions_mm.size(); ++v) {
    ASSERT_EQ(state.positions_mm[v], anatomy->surface.positions_mm[v]);
  }
}

TEST(Simulator, SmileMovesTheCornerUpAndOutKeepsVolumeAndReturnsToRest) {
  const auto anatomy = shared_face_patch();
  Simulator simulator(anatomy);
  FaceState state = simulator.rest();
  SettleReport report = simulator.settle(with(*anatomy, "zygomaticus_major", 1.0, 1.0), state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.inverted_elements, 0);
  EXPECT_LT(report.mean_volume_change, 0.03);
  const int corner = nearest_vertex(*anatomy, 30.0, -76.0, [](int) { return true; });
  const Vec3 moved = state.positions_mm[corner] - anatomy->surface.positions_mm[corner];
  EXPECT_GT(moved.norm(), 8.0);
  EXPECT_LT(moved.norm(), 15.0);
  EXPECT_GT(moved.x(), 0.5 * moved.y());
  EXPECT_GT(moved.y(), 0.5 * moved.x());
  report = simulator.settle(at_rest(*anatomy), state);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(largest_distance(state.positions_mm, simulator.rest().positions_mm), 1e-6);
}

TEST(Simulator, MirroredControlsGiveTheMirroredFace) {
  const auto anatomy = shared_face_patch(coarse());
  SettleOptions tight;
  tight.relative_residual = 1e-14;
  Simulator simulator(anatomy, {}, tight);
  FaceState left = simulator.rest();
  FaceState right = simulator.rest();
  simulator.settle(with(*anatomy, "zygomaticus_major", 0.3, 0.0), left);
  simulator.settle(with(*anatomy, "zygomaticus_major", 0.0, 0.3), right);
  double largest = 0.0;
  for (std::size_t v = 0; v < anatomy->surface.positions_mm.size(); ++v) {
    const Vec3 p = anatomy->surface.positions_mm[v];
    const int twin = nearest_vertex(
        *anatomy, -p.x(), p.y(), [&](int u) { return anatomy->region[u] == anatomy->region[v]; });
    const Vec3 mirrored(
        -left.positions_mm[v].x(), left.positions_mm[v].y(), left.positions_mm[v].z());
    largest = std::max(largest, (right.positions_mm[twin] - mirrored).norm());
  }
  EXPECT_LT(largest, 1e-9);
}

TEST(Simulator, SensitivitiesMatchCentralDifferences) {
  const auto anatomy = shared_face_patch(coarse());
  SettleOptions tight;
  tight.relative_residual = 1e-12;
  Simulator simulator(anatomy, {}, tight);
  Controls controls = with(*anatomy, "zygomaticus_major", 0.4, 0.3);
  controls.contraction[anatomy->muscle_index("depressor_anguli_oris_L")] = 0.2;
  controls.jaw_rad = 0.1;
  FaceState state = simulator.rest();
  ASSERT_TRUE(simulator.settle(controls, state).converged);
  const Sensitivity exact = simulator.surface_sensitivity(controls, state);
  EXPECT_FALSE(exact.damped);
  const Eigen::MatrixXd& sensitivity = exact.mm;
  const int jaw = static_cast<int>(anatomy->muscles.size());
  for (const int control : {0, anatomy->muscle_index("depressor_anguli_oris_L"), jaw}) {
    const double h = 3e-4;
    Eigen::VectorXd difference(sensitivity.rows());
    std::array<FaceState, 2> moved{state, state};
    for (const int side : {0, 1}) {
      Controls shifted = controls;
      double& value = control == jaw ? shifted.jaw_rad : shifted.contraction[control];
      value += side == 0 ? h : -h;
      ASSERT_TRUE(simulator.settle(shifted, moved[side]).converged);
    }
    for (Eigen::Index k = 0; k < difference.size(); ++k) {
      difference[k] =
          (moved[0].positions_mm[k / 3][k % 3] - moved[1].positions_mm[k / 3][k % 3]) / (2 * h);
    }
    EXPECT_LT((difference - sensitivity.col(control)).norm(), 1e-4 * difference.norm())
        << "control " << control;
  }
}

TEST(Simulator, OrderOfMusclesHasNoEffect) {
  Anatomy reordered = make_face_patch(coarse());
  std::reverse(reordered.muscles.begin(), reordered.muscles.end());
  const auto anatomy = shared_face_patch(coarse());
  Simulator a(anatomy);
  Simulator b(std::make_shared<const Anatomy>(reordered));
  FaceState x = a.rest();
  FaceState y = b.rest();
  Controls controls = with(*anatomy, "zygomaticus_major", 0.6, 0.2);
  controls.contraction[anatomy->muscle_index("depressor_anguli_oris_L")] = 0.3;
  a.settle(controls, x);
  std::reverse(controls.contraction.begin(), controls.contraction.end());
  b.settle(controls, y);
  EXPECT_LT(largest_distance(x.positions_mm, y.positions_mm), 1e-3);
}

TEST(Simulator, JawOpensLeavesTheUpperLipAndReturns) {
  const auto anatomy = shared_face_patch(coarse());
  Simulator simulator(anatomy);
  FaceState state = simulator.rest();
  Controls controls = at_rest(*anatomy);
  controls.jaw_rad = anatomy->jaw.full_rad;
  EXPECT_TRUE(simulator.settle(controls, state).converged);
  const auto moved = [&](double y, Region region) -> Vec3 {
    const int v =
        nearest_vertex(*anatomy, 0.0, y, [&](int u) { return anatomy->region[u] == region; });
    return state.positions_mm[v] - anatomy->surface.positions_mm[v];
  };
  EXPECT_LT(moved(-76.0, Region::kUpperLip).norm(), 3.0);
  EXPECT_LT(moved(-76.0, Region::kLowerLip).y(), -15.0);
  controls.jaw_rad = 0.0;
  EXPECT_TRUE(simulator.settle(controls, state).converged);
  EXPECT_LT(largest_distance(state.positions_mm, simulator.rest().positions_mm), 1e-6);
}

TEST(Simulator, RejectsControlsThatAreNoControls) {
  const auto anatomy = shared_face_patch(coarse());
  Simulator simulator(anatomy);
  FaceState state = simulator.rest();
  for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(simulator.settle(with(*anatomy, "zygomaticus_major", bad, 0.0), state),
                 InputError);
    Controls jaw = at_rest(*anatomy);
    jaw.jaw_rad = bad > 1.0 ? bad : -std::abs(bad);
    EXPECT_THROW(simulator.settle(jaw, state), InputError);
  }
  EXPECT_EQ(state.positions_mm, simulator.rest().positions_mm);
}

TEST(Simulator, SameHistorySameBits) {
  const auto anatomy = shared_face_patch(coarse());
  std::array<std::vector<Vec3>, 2> ends;
  for (std::vector<Vec3>& end : ends) {
    Simulator simulator(anatomy);
    FaceState state = simulator.rest();
    for (const double c : {0.1, 0.2, 0.35}) {
      simulator.settle(with(*anatomy, "zygomaticus_major", c, 0.5 * c), state);
    }
    end = state.positions_mm;
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST(Embedding, SkinAtRestIsTheAuthoredSkin) {
  Anatomy anatomy = make_face_patch(coarse());
  anatomy.skin.mesh = anatomy.surface;
  const int n = static_cast<int>(anatomy.surface.positions_mm.size());
  for (int v = 0; v <= n; ++v) anatomy.skin.embedding.begin.push_back(2 * v);
  for (int v = 0; v < n; ++v) {
    anatomy.skin.embedding.index.insert(anatomy.skin.embedding.index.end(), {v, (v + 1) % n});
    anatomy.skin.embedding.weight.insert(anatomy.skin.embedding.weight.end(), {0.25F, 0.75F});
  }
  FaceState state;
  state.positions_mm = anatomy.surface.positions_mm;
  std::vector<Vec3> skin;
  embed_skin(anatomy, state, skin);
  EXPECT_EQ(skin, anatomy.skin.mesh.positions_mm);
  for (Vec3& p : state.positions_mm) p += Vec3(1.0, 2.0, 3.0);
  embed_skin(anatomy, state, skin);
  EXPECT_LT((skin[5] - anatomy.skin.mesh.positions_mm[5] - Vec3(1.0, 2.0, 3.0)).norm(), 1e-12);
}

}  // namespace
}  // namespace zygoma
