// Muscles and jaw: HC-22 to HC-31, HC-33.
#include <gtest/gtest.h>

#include <limits>

#include "face/muscle_field.h"
#include "src/base/check.h"
#include "tests/hard/floating_point_traps.h"
#include "tests/hard/record.h"
#include "tests/hard/scenes.h"

namespace zygoma::hard {
namespace {

using HC22 = Trapped;
using HC23 = Trapped;
using HC24 = Trapped;
using HC25 = Trapped;
using HC26 = Trapped;
using HC27 = Trapped;
using HC28 = Trapped;
using HC30 = Trapped;
using HC29 = testing::Test;  // comparing a NaN with anything is trapped already
using HC31 = Trapped;
using HC33 = Trapped;

// Fibres whose contraction 1 is the factor `raw` of equation (3), their radius this share of
// their length; the frontalis no longer than Waters', and from bone.
Anatomy with_raw_muscles(Anatomy anatomy, double raw, double radius_share) {
  for (Muscle& muscle : anatomy.muscles) {
    constexpr double kLongest_mm = 43.0;
    if (muscle.ring) continue;
    const Vec3 m = muscle.emergence_mm - muscle.attachment_mm;
    if (m.norm() > kLongest_mm && muscle.scalp_share > 0.0) {
      muscle.emergence_mm = muscle.attachment_mm + kLongest_mm * m.normalized();
    }
    muscle.scalp_share = 0.0;
    muscle.largest_shortening = raw;
    muscle.radius_mm = radius_share * (muscle.emergence_mm - muscle.attachment_mm).norm();
  }
  return anatomy;
}

std::string describe(const SettleReport& report) {
  return std::string(report.converged ? "converges" : "not converged (reported)") + " in " +
         std::to_string(report.iterations) + " steps, residual " + figure(report.residual) + ", " +
         std::to_string(report.inverted_elements) + " inverted, mean |dV| " +
         figure(100.0 * report.mean_volume_change) + " %";
}

TEST_F(HC22, NoContractionGivesTheMeshWhateverTheZones) {
  const Anatomy patch = make_face_patch(coarse_patch());
  const auto wide = shared(with_raw_muscles(patch, 0.4, 3.0));
  const auto head = generic_head(500);
  for (const Tissue& tissue : topologies()) {
    for (const auto& anatomy : {wide, head}) {
      Simulator simulator(anatomy, tissue.model);
      FaceState state = simulator.rest();
      const SettleReport report = simulator.settle(at_rest(*anatomy), state);
      EXPECT_TRUE(report.converged);
      EXPECT_EQ(report.iterations, 0);
      for (std::size_t v = 0; v < anatomy->region.size(); ++v) {
        ASSERT_EQ(state.positions_mm[v], anatomy->surface.positions_mm[v]);
      }
    }
  }
  record(
      "all contractions 0, radii of three lengths so that all zones overlap, and the default head",
      "the input mesh, same bits, 0 steps",
      "same bits or 1e-9");
}

TEST_F(HC23, OrderOfMusclesHasNoEffect) {
  const Anatomy anatomy = make_face_patch(coarse_patch());
  Random random(11);
  const Controls controls = random_controls(anatomy, 0.6, random);
  std::vector<int> order(anatomy.muscles.size());
  for (std::size_t m = 0; m < order.size(); ++m) order[m] = static_cast<int>(m);
  SettleOptions tight;
  tight.relative_residual = 1e-13;
  std::vector<Vec3> first;
  double worst = 0.0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    if (seed > 0) std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    Anatomy reordered = anatomy;
    Controls again = controls;
    for (std::size_t m = 0; m < order.size(); ++m) {
      reordered.muscles[m] = anatomy.muscles[order[m]];
      again.contraction[m] = controls.contraction[order[m]];
    }
    Simulator simulator(shared(reordered), {}, tight);
    FaceState state = simulator.rest();
    simulator.settle(again, state);
    if (seed == 0) first = state.positions_mm;
    worst = std::max(worst, largest_distance(first, state.positions_mm));
  }
  EXPECT_LT(worst, 1e-9);
  record("random expression up to 0.6, muscles shuffled three times",
         "nodes differ by " + figure(worst) + " mm",
         "order has no effect (1e-9 mm)");
}

TEST_F(HC24, FoldingOverIsForetoldAndReported) {
  const Anatomy patch = make_face_patch();
  const int zygomaticus = patch.muscle_index("zygomaticus_major_L");
  for (const double fold : {0.5, 0.99, 1.01, 3.0}) {
    Anatomy anatomy = patch;
    Muscle& muscle = anatomy.muscles[zygomaticus];
    muscle.radius_mm *= fold_measure(muscle) / fold;
    EXPECT_NEAR(fold_measure(muscle), fold, 1e-12);
    EXPECT_EQ(fold_measure(muscle) >= 1.0, fold > 1.0);
    Controls controls = at_rest(anatomy);
    controls.contraction[zygomaticus] = 1.0;
    Simulator simulator(shared(anatomy));
    FaceState state = simulator.rest();
    const SettleReport report = simulator.settle(controls, state);
    for (const Vec3& p : state.positions_mm) ASSERT_TRUE(p.allFinite());
    EXPECT_TRUE(report.converged) << fold;
    // The targets themselves, whether tissue follows them or not.
    const MuscleField field = make_muscle_field(anatomy, simulator.lattice());
    std::vector<Vec3> target = simulator.lattice().rest_mm;
    for (const MusclePull& pull : field.pulls[zygomaticus]) {
      target[pull.column] += pull.displacement_mm;
    }
    int folded = 0;
    for (const Triangle& t : anatomy.surface.triangles) {
      const auto area = [&](const std::vector<Vec3>& x) -> Vec3 {
        return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
      };
      folded += area(target).dot(area(simulator.lattice().rest_mm)) < 0.0;
    }
    EXPECT_TRUE(fold > 1.0 || folded == 0) << folded;
    record("one zygomaticus of fold measure " + std::to_string(fold).substr(0, 4),
           "measure says " + std::string(fold < 1.0 ? "no fold" : "fold") + ", " +
               std::to_string(folded) + " triangles of its targets are folded; " + describe(report),
           "diagnostic above 1; finite; inverted count reported");
  }
}

// Lowest height of the fascia over the bone at rest, along the normal of its nearest node.
double lowest_over_bone(const Lattice& lattice, const Anatomy& anatomy, const FaceState& state) {
  SurfaceMesh bone = anatomy.surface;
  for (int v = 0; v < lattice.num_vertices; ++v) {
    bone.positions_mm[v] = lattice.rest_mm[lattice.columns[v].bone()];
  }
  const std::vector<Vec3> normal = smooth_normals(bone, lattice.neighbors, 0);
  double lowest = 1e30;
  for (const Column& column : lattice.columns) {
    const Vec3& p = state.positions_mm[column.fascia()];
    int nearest = 0;
    for (int u = 1; u < lattice.num_vertices; ++u) {
      if ((p - bone.positions_mm[u]).norm() < (p - bone.positions_mm[nearest]).norm()) nearest = u;
    }
    lowest = std::min(lowest, (p - bone.positions_mm[nearest]).dot(normal[nearest]));
  }
  return lowest;
}

TEST_F(HC25, FrontalisAndTheSkull) {
  const Anatomy patch = make_face_patch();
  for (const bool raw : {false, true}) {
    const auto anatomy = shared(raw ? with_raw_muscles(patch, 0.35, 0.7) : patch);
    std::array<double, 2> lowest{};
    std::string how;
    for (const bool contact : {false, true}) {
      TissueModel model;
      if (contact) model.effects.push_back({"skull_contact", {}});
      Simulator simulator(anatomy, model);
      FaceState state = simulator.rest();
      const SettleReport report = simulator.settle(with(*anatomy,
                                                        {{"occipitofrontalis_inner", 1.0},
                                                         {"occipitofrontalis_major", 1.0},
                                                         {"occipitofrontalis_outer", 1.0}}),
                                                   state);
      EXPECT_TRUE(report.converged);
      lowest[contact] = lowest_over_bone(simulator.lattice(), *anatomy, state);
      how = describe(report);
    }
    EXPECT_GE(lowest[1], 0.0);
    EXPECT_TRUE(!raw || lowest[0] < 0.0) << "the case is not hard any more";
    record(raw ? "frontalis at raw 0.35, radii of 0.7 of the length, skull contact on"
               : "the standard frontalis at 1, skull contact on",
           "fascia at least " + figure(lowest[1]) + " mm above the bone (" + figure(lowest[0]) +
               " without contact); " + how,
           "distance >= 0");
  }
}

TEST_F(HC26, AntagonistsFullyOn) {
  const auto head = generic_head(500);
  const std::vector<std::pair<std::string, std::vector<Pull>>> pairs{
      {"zygomaticus and angular depressor",
       {{"zygomaticus_major", 1.0}, {"depressor_anguli_oris", 1.0}}},
      {"inner frontalis and corrugator",
       {{"occipitofrontalis_inner", 1.0}, {"corrugator_supercilii", 1.0}}}};
  for (const auto& [name, pulls] : pairs) {
    Simulator simulator(head);
    FaceState state = simulator.rest();
    const SettleReport report = simulator.settle(with(*head, pulls), state);
    EXPECT_TRUE(report.converged) << name;
    EXPECT_EQ(report.inverted_elements, 0) << name;
    const double moved = largest_distance(state.positions_mm, simulator.rest().positions_mm);
    EXPECT_LT(moved, 20.0) << name;
    record(name + " at 1, default head of 500 vertices",
           describe(report) + "; moves " + figure(moved) + " mm",
           "bounded, converges");
  }
}

// Zygomaticus, frontalis and angular depressor at the raw factor 0.3 of equation (3), from rest.
// Their targets overlap and together fold over: where every Newton of the prototype failed.
void settle_the_known_failure(const FacePatchOptions& options) {
  const auto anatomy = shared(with_raw_muscles(make_face_patch(options), 0.3, 0.5));
  Simulator simulator(anatomy);
  FaceState state = simulator.rest();
  const SettleReport report = simulator.settle(with(*anatomy,
                                                    {{"zygomaticus_major", 1.0},
                                                     {"occipitofrontalis_inner", 1.0},
                                                     {"occipitofrontalis_major", 1.0},
                                                     {"occipitofrontalis_outer", 1.0},
                                                     {"depressor_anguli_oris", 1.0}}),
                                               state);
  for (const Vec3& p : state.positions_mm) ASSERT_TRUE(p.allFinite());
  EXPECT_TRUE(report.converged);
  const double moved = largest_distance(state.positions_mm, simulator.rest().positions_mm);
  EXPECT_LT(moved, 40.0);
  record(
      "zygomaticus, frontalis and angular depressor at raw 0.3, radii of half the length, cold "
      "start, " +
          std::to_string(simulator.lattice().rest_mm.size()) + " nodes",
      describe(report) + "; moves " + figure(moved) + " mm",
      "converges; bounded");
}

TEST_F(HC26, KnownFailureOfOpposingMuscles) { settle_the_known_failure(coarse_patch()); }

TEST_F(HC26, KnownFailureOfOpposingMusclesOnAFineMesh) {
  if (!long_tests()) GTEST_SKIP() << "ZYGOMA_LONG_TESTS is not set";
  FacePatchOptions options;
  options.half_columns = 25;
  options.row_mm = 3.5;
  options.rows_below_mouth = 12;
  options.rows_above_mouth = 39;
  settle_the_known_failure(options);
}

TEST_F(HC27, AllMusclesAtOne) {
  const auto head = generic_head(500);
  const auto patch = shared(make_face_patch());
  for (const Tissue& tissue : topologies()) {
    for (const auto& anatomy : {head, patch}) {
      if (kSanitized && anatomy == head) continue;
      Simulator simulator(anatomy, tissue.model);
      FaceState state = simulator.rest();
      Controls controls = at_rest(*anatomy);
      std::fill(controls.contraction.begin(), controls.contraction.end(), 1.0);
      const SettleReport report = simulator.settle(controls, state);
      for (const Vec3& p : state.positions_mm) ASSERT_TRUE(p.allFinite());
      EXPECT_TRUE(report.converged || report.residual > SettleOptions{}.relative_residual);
      EXPECT_LE(report.iterations, 13 * SettleOptions{}.max_iterations);  // 3 + 9 parts and more
      const bool prisms = tissue.model.lattice.topology == Topology::kPrisms;
      EXPECT_TRUE(report.converged || !prisms);
      record("all muscles at 1, " + std::string(anatomy == head ? "default head" : "patch") + ", " +
                 tissue.name,
             describe(report),
             "converges or reports failure within the budget; inverted count reported");
    }
  }
}

TEST_F(HC27, EveryMuscleAloneAtOneInvertsNothing) {
  const auto head = generic_head(500);
  Simulator simulator(head);
  int most_steps = 0;
  double worst_change = 0.0;
  for (std::size_t m = 0; m < head->muscles.size(); m += kSanitized ? 4 : 1) {
    FaceState state = simulator.rest();
    Controls controls = at_rest(*head);
    controls.contraction[m] = 1.0;
    const SettleReport report = simulator.settle(controls, state);
    EXPECT_TRUE(report.converged) << head->muscles[m].name;
    EXPECT_EQ(report.inverted_elements, 0)
        << head->muscles[m].name << ": "
        << inverted_elements(simulator.lattice(), state.positions_mm);
    most_steps = std::max(most_steps, report.iterations);
    worst_change = std::max(worst_change, report.mean_volume_change);
  }
  record("each of the " + std::to_string(head->muscles.size()) +
             " muscles alone at 1, default head of 500 vertices",
         "all converge, within " + std::to_string(most_steps) +
             " steps, 0 inverted, mean |dV| up to " + figure(100.0 * worst_change) + " %",
         "converges, 0 inverted");
}

TEST_F(HC27, BasicExpressionsInvertNothing) {
  const auto head = generic_head(500);
  Simulator simulator(head);
  for (const Expression& expression : basic_expressions()) {
    FaceState state = simulator.rest();
    const SettleReport report = simulator.settle(controls_of(expression.pose, *head), state);
    EXPECT_TRUE(report.converged) << expression.name;
    EXPECT_EQ(report.inverted_elements, 0)
        << expression.name << ": " << inverted_elements(simulator.lattice(), state.positions_mm);
    record(expression.name + " (" + expression.units + "), default head of 500 vertices",
           describe(report),
           "converges, 0 inverted");
  }
}

// Motion of the middle of a lip between two states.
double lip_motion(const Anatomy& anatomy, Region lip, const FaceState& from, const FaceState& to) {
  double largest = 0.0;
  for (std::size_t v = 0; v < anatomy.region.size(); ++v) {
    const bool middle = std::abs(anatomy.surface.positions_mm[v].x()) < 12.0;
    if (anatomy.region[v] != lip || !middle) continue;
    largest = std::max(largest, (to.positions_mm[v] - from.positions_mm[v]).norm());
  }
  return largest;
}

TEST_F(HC28, AMuscleOfOneLipLeavesTheOtherAlone) {
  for (const bool is_head : {false, true}) {
    const auto anatomy = is_head ? generic_head(500) : shared(make_face_patch());
    Simulator simulator(anatomy);
    for (const double jaw_rad : {0.0, 0.3}) {
      FaceState before = simulator.rest();
      ASSERT_TRUE(simulator.settle(with(*anatomy, {}, jaw_rad), before).converged);
      const auto pull = [&](const std::string& muscle) {
        FaceState after = before;
        EXPECT_TRUE(simulator.settle(with(*anatomy, {{muscle, 1.0}}, jaw_rad), after).converged);
        return std::array{lip_motion(*anatomy, Region::kUpperLip, before, after),
                          lip_motion(*anatomy, Region::kLowerLip, before, after)};
      };
      const auto [upper, dragged_lower] = pull("levator_labii_superioris");
      const auto [dragged_upper, lower] = pull("depressor_labii_inferioris");
      EXPECT_LT(dragged_lower, 0.15 * upper);
      EXPECT_LT(dragged_upper, 0.15 * lower);
      record("one lip's muscles at 1, " + std::string(is_head ? "default head" : "patch") +
                 (jaw_rad > 0.0 ? ", jaw open by 17 deg" : ", mouth closed"),
             "upper lip " + figure(upper) + " mm, takes the lower one by " + figure(dragged_lower) +
                 "; lower lip " + figure(lower) + ", takes the upper by " + figure(dragged_upper),
             "the other lip is not dragged (15 %)");
    }
  }
}

TEST_F(HC28, SmileWithTheJawFromClosedToWideOpen) {
  double worst_change = 0.0;
  for (const int num_vertices : {300, 500, 1000}) {
    const auto head = generic_head(num_vertices);
    Simulator simulator(head);
    FaceState state = simulator.rest();
    for (const double degrees : {0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0}) {
      Controls controls = smile(*head, 0.7);
      controls.jaw_rad = degrees * 3.14159265358979 / 180.0;
      const SettleReport report = simulator.settle(controls, state);
      EXPECT_TRUE(report.converged) << degrees << " deg, " << num_vertices << " vertices";
      EXPECT_EQ(report.inverted_elements, 0)
          << degrees << " deg, " << num_vertices
          << " vertices: " << inverted_elements(simulator.lattice(), state.positions_mm);
      worst_change = std::max(worst_change, report.mean_volume_change);
    }
  }
  record("smile at 0.7, jaw 0 to 35 deg in 5 deg steps, default head of 300, 500, 1000 vertices",
         "converges at every step; no element inverted, mean |dV| up to " +
             figure(100.0 * worst_change) + " %",
         "converges; no element inverted");
}

TEST_F(HC29, AMuscleThatCannotPullIsNamed) {
  const Anatomy good = make_face_patch(coarse_patch());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_named = [&](const char* what, auto spoil) {
    Anatomy anatomy = good;
    Muscle& muscle = anatomy.muscles[5];
    spoil(muscle);
    try {
      const FaceEnergy energy(anatomy);
      ADD_FAILURE() << "accepted: " << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(muscle.name), std::string::npos) << error.what();
    }
  };
  expect_named("no length", [](Muscle& m) { m.emergence_mm = m.attachment_mm; });
  expect_named("far from the face", [](Muscle& m) {
    m.attachment_mm += Vec3(0, 0, 500);
    m.emergence_mm += Vec3(0, 0, 500);
  });
  expect_named("no radius", [](Muscle& m) { m.radius_mm = 0.0; });
  expect_named("negative radius", [](Muscle& m) { m.radius_mm = -5.0; });
  expect_named("radius NaN", [&](Muscle& m) { m.radius_mm = nan; });
  expect_named("end NaN", [&](Muscle& m) { m.emergence_mm.y() = nan; });
  expect_named("attachment NaN", [&](Muscle& m) { m.attachment_mm.x() = nan; });
  expect_named("shortening NaN", [&](Muscle& m) { m.largest_shortening = nan; });
  expect_named("no shortening", [](Muscle& m) { m.largest_shortening = 0.0; });
  expect_named("shortening above 1", [](Muscle& m) { m.largest_shortening = 1.5; });
  record(
      "a muscle of no length, off the face, of radius 0, < 0 or NaN, end NaN, shortening 0, "
      "1.5 or NaN",
      "each rejected, with the name of the muscle",
      "rejected with a message that names the muscle",
      Outcome::kRefused);
}

// Lowest height of the upper lip's rim over the lower lip's, where the two touch at rest.
double lowest_lip_gap_mm(const Anatomy& anatomy, const FaceState& state) {
  constexpr double kTouching_mm = 1.0;
  const std::vector<Vec3>& rest = anatomy.surface.positions_mm;
  double lowest = 1e30;
  for (std::size_t u = 0; u < rest.size(); ++u) {
    if (anatomy.region[u] != Region::kUpperLip) continue;
    for (std::size_t l = 0; l < rest.size(); ++l) {
      const bool touch =
          anatomy.region[l] == Region::kLowerLip && (rest[u] - rest[l]).norm() < kTouching_mm;
      if (!touch) continue;
      lowest = std::min(lowest, state.positions_mm[u].y() - state.positions_mm[l].y());
    }
  }
  return lowest;
}

TEST_F(HC30, LipsOfAPursedOrPressedMouthDoNotCross) {
  const auto head = generic_head(500);
  TissueModel touching;
  touching.effects.push_back({"lip_contact", {}});
  Simulator simulator(head);
  Simulator with_contact(head, touching);
  const double rest_gap_mm = lowest_lip_gap_mm(*head, simulator.rest());
  const std::vector<std::pair<std::string, std::vector<Pull>>> cases{
      {"both rings of the mouth, peripheral parts",
       {{"orbicularis_oris_superior", 1.0}, {"orbicularis_oris_inferior", 1.0}}},
      {"both rings of the mouth, marginal parts",
       {{"orbicularis_oris_marginal_superior", 1.0}, {"orbicularis_oris_marginal_inferior", 1.0}}},
      {"the upper rings alone",
       {{"orbicularis_oris_superior", 1.0}, {"orbicularis_oris_marginal_superior", 1.0}}},
      {"the lower rings alone",
       {{"orbicularis_oris_inferior", 1.0}, {"orbicularis_oris_marginal_inferior", 1.0}}}};
  for (const auto& [name, pulls] : cases) {
    double gap_mm[2];
    SettleReport report;
    for (const bool contact : {false, true}) {
      Simulator& face = contact ? with_contact : simulator;
      FaceState state = face.rest();
      report = face.settle(with(*head, pulls), state);
      EXPECT_TRUE(report.converged) << name;
      EXPECT_EQ(report.inverted_elements, 0) << name;
      gap_mm[contact] = lowest_lip_gap_mm(*head, state);
    }
    EXPECT_GT(gap_mm[1], -0.1) << name;
    EXPECT_GT(gap_mm[0], -1.8) << name;
    record(name + " at 1, lip contact on, default head of 500 vertices",
           describe(report) + "; upper lip at least " + figure(gap_mm[1]) +
               " mm above the lower one (" + figure(gap_mm[0]) + " without contact, " +
               figure(rest_gap_mm) + " at rest)",
           "lips do not interpenetrate (0.1 mm)");
  }
}

struct Eyeball {
  Vec3 centre_mm;
  double radius_mm;
};

Eyeball left_eyeball(const Anatomy& anatomy) {
  for (const RigidPart& part : anatomy.rigid_parts) {
    if (part.name != "eyeball_left") continue;
    Vec3 low = part.mesh.positions_mm.front();
    Vec3 high = low;
    for (const Vec3& p : part.mesh.positions_mm) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    // The cornea bulges: the ball's radius is that across.
    const double radius = 0.5 * (high.x() - low.x());
    return {{0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), high.z() - radius}, radius};
  }
  return {};
}

TEST_F(HC30, LidsCloseAndStayInFrontOfTheEye) {
  const auto head = generic_head(500);
  const Eyeball eye = left_eyeball(*head);
  ASSERT_GT(eye.radius_mm, 5.0);
  Simulator simulator(head);
  FaceState state = simulator.rest();

  // The skin of the lids; what turns in behind their margin lies in the eyeball at rest already.
  std::vector<int> lids;
  for (std::size_t v = 0; v < head->region.size(); ++v) {
    const bool lid = head->region[v] == Region::kUpperLid || head->region[v] == Region::kLowerLid;
    const Vec3 p = head->surface.positions_mm[v] - eye.centre_mm;
    if (lid && p.norm() > eye.radius_mm + 1.0 && p.x() > -20.0) lids.push_back(static_cast<int>(v));
  }
  const auto clearance_mm = [&] {
    double least = 1e30;
    for (const int v : lids) {
      least = std::min(least, (state.positions_mm[v] - eye.centre_mm).norm() - eye.radius_mm);
    }
    return least;
  };
  const auto opening_mm = [&] {
    double upper = 1e30;
    double lower = -1e30;
    for (const int v : lids) {
      const double height = state.positions_mm[v].y();
      if (std::abs(head->surface.positions_mm[v].x() - eye.centre_mm.x()) > 6.0) continue;
      if (head->region[v] == Region::kUpperLid) upper = std::min(upper, height);
      if (head->region[v] == Region::kLowerLid) lower = std::max(lower, height);
    }
    return upper - lower;
  };
  const double open_mm = opening_mm();
  EXPECT_GT(open_mm, 6.0);
  double least_mm = clearance_mm();
  SettleReport report;
  const auto close = [&](const std::vector<Pull>& pulls) {
    report = simulator.settle(with(*head, pulls), state);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.inverted_elements, 0);
    least_mm = std::min(least_mm, clearance_mm());
  };
  for (const double c : {0.2, 0.4, 0.6, 0.8, 1.0}) close({{"orbicularis_oculi_palpebral", c}});
  const double closed_mm = opening_mm();
  EXPECT_LT(closed_mm, 0.7);
  EXPECT_GT(closed_mm, -0.7);
  close({{"orbicularis_oculi_palpebral", 1.0}, {"orbicularis_oculi_orbital", 1.0}});
  EXPECT_LT(opening_mm(), 0.7);
  EXPECT_GT(opening_mm(), -2.0);
  EXPECT_GT(least_mm, 0.0);
  record("rings of the eyes: inner part from 0 to 1, then both at 1, default head of 500 vertices",
         describe(report) + "; opening from " + figure(open_mm) + " to " + figure(closed_mm) +
             " and " + figure(opening_mm()) + " mm, lids at least " + figure(least_mm) +
             " mm in front of the eyeball",
         "lids close without crossing the eyeball");
}

TEST_F(HC31, JawOpensAndReturnsAndIsRefusedBeyond) {
  constexpr double kDegree = 3.14159265358979 / 180.0;
  for (const Tissue& tissue : topologies()) {
    const auto head = generic_head(300);
    Simulator simulator(head, tissue.model);
    FaceState state = simulator.rest();
    const SettleReport open = simulator.settle(with(*head, {}, 30.0 * kDegree), state);
    const bool prisms = tissue.model.lattice.topology == Topology::kPrisms;
    EXPECT_TRUE(open.converged || !prisms) << tissue.name;
    EXPECT_TRUE(simulator.settle(at_rest(*head), state).converged) << tissue.name;
    const double off = largest_distance(state.positions_mm, simulator.rest().positions_mm);
    EXPECT_LT(off, 1e-6) << tissue.name;
    const FaceState before = state;
    EXPECT_THROW(simulator.settle(with(*head, {}, 60.0 * kDegree), state), InputError);
    EXPECT_EQ(state.positions_mm, before.positions_mm);
    record("jaw 0, 30, 0 deg, default head, " + tissue.name,
           "open: " + describe(open) + "; closed again to " + figure(off) + " mm; 60 deg refused",
           "returns exactly (1e-6 mm); 60 deg refused",
           open.converged ? Outcome::kHolds : Outcome::kOpen);
  }
}

struct Drift {
  double on_mm = 0.0;   // from the first time
  double off_mm = 0.0;  // from rest
};

// One frame on, one off, for 10 s at 30 frames a second: 15 Hz.
Drift square_wave(double relative_residual) {
  const auto anatomy = shared(make_face_patch(small_patch()));
  SettleOptions options;
  options.relative_residual = relative_residual;
  Simulator simulator(anatomy, {}, options);
  FaceState state = simulator.rest();
  std::vector<Vec3> first_on;
  Drift drift;
  for (int frame = 0; frame < repetitions(300); ++frame) {
    const bool on = frame % 2 == 0;
    EXPECT_TRUE(simulator.advance(smile(*anatomy, on ? 1.0 : 0.0), 1.0 / 30.0, state).converged);
    if (frame == 0) first_on = state.positions_mm;
    double& off = on ? drift.on_mm : drift.off_mm;
    off = std::max(
        off, largest_distance(on ? first_on : simulator.rest().positions_mm, state.positions_mm));
  }
  EXPECT_NEAR(state.time_s, repetitions(300) / 30.0, 1e-9);
  return drift;
}

TEST_F(HC33, ASquareWaveDoesNotDrift) {
  constexpr double kSettledMm = 0.02;  // what the usual tolerance leaves to go
  for (const double relative_residual : {1e-4, 1e-9}) {
    const Drift drift = square_wave(relative_residual);
    EXPECT_LT(drift.off_mm, 1e-4);
    EXPECT_LT(drift.on_mm, relative_residual < 1e-8 ? 1e-3 : kSettledMm);
    record("smile switched between 0 and 1 at 15 Hz for 10 s, settled at every frame to " +
               figure(relative_residual) + " of the load",
           "off: within " + figure(drift.off_mm) + " mm of rest; on: within " +
               figure(drift.on_mm) + " mm of the first time",
           "no drift (" + figure(kSettledMm) + " mm), no energy growth");
  }
}

}  // namespace
}  // namespace zygoma::hard
