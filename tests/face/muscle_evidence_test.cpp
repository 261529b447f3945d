// What the muscles of the default head do, in millimetres, against what faces were measured to do:
// a full smile takes the corner of the mouth 9 to 14 mm up and out at 40 to 55 degrees (Flynn et
// al. 2015, Tarantili et al. 2005), a full frontalis lifts the brow by 6 to 12 mm.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "face/facs.h"
#include "face/generic_head.h"
#include "face/muscle_field.h"
#include "face/prism.h"

namespace zygoma {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

class MuscleEvidence : public testing::Test {
 protected:
  SettleReport settle(const std::string& text) {
    state_ = simulator_.rest();
    const SettleReport report = simulator_.settle(controls_of(pose_of(text), *head_), state_);
    EXPECT_TRUE(report.converged) << text;
    EXPECT_EQ(report.inverted_elements, 0) << text;
    embed_skin(*head_, state_, skin_mm_);
    return report;
  }

  // Motion of a point of a named curve, share 0 to 1 along it.
  Vec3 motion(const std::string& name, double share) const {
    for (const NamedCurve& curve : head_->curves) {
      if (curve.name != name) continue;
      const double last = static_cast<double>(curve.skin_vertices.size() - 1);
      const int vertex = curve.skin_vertices[std::lround(share * last)];
      return skin_mm_[vertex] - head_->skin.mesh.positions_mm[vertex];
    }
    ADD_FAILURE() << "no curve " << name;
    return Vec3::Zero();
  }

  // Of the tissue below the left cheek.
  double cheek_volume_mm3(const std::vector<Vec3>& x) const {
    double volume = 0.0;
    for (const Prism& prism : simulator_.lattice().prisms) {
      Vec3 centre = Vec3::Zero();
      for (const int node : prism.node) centre += simulator_.lattice().rest_mm[node] / 6.0;
      const bool cheek =
          centre.x() > 25.0 && centre.x() < 65.0 && centre.y() < -12.0 && centre.y() > -62.0;
      if (cheek) volume += signed_volume(prism, x);
    }
    return volume;
  }

  std::shared_ptr<const Anatomy> head_ =
      std::make_shared<const Anatomy>(make_generic_head({}, {500, 1, 64}));
  Simulator simulator_{head_};
  FaceState state_;
  std::vector<Vec3> skin_mm_;
};

TEST_F(MuscleEvidence, ASmileTakesTheCornersUpAndOut) {
  settle("12");
  for (const auto& [end, side] : {std::pair{1.0, 1.0}, std::pair{0.0, -1.0}}) {
    const Vec3 corner = motion("upper_lip", end);
    EXPECT_GE(corner.norm(), 9.0);
    EXPECT_LE(corner.norm(), 14.0);
    const double degrees = std::atan2(corner.y(), side * corner.x()) / kDegree;
    EXPECT_GE(degrees, 40.0);
    EXPECT_LE(degrees, 55.0);
  }
  const double before = cheek_volume_mm3(simulator_.rest().positions_mm);
  const double after = cheek_volume_mm3(state_.positions_mm);
  EXPECT_GT(before, 1000.0);
  EXPECT_NEAR(after / before, 1.0, 0.03);
}

TEST_F(MuscleEvidence, FrontalisLiftsTheBrow) {
  settle("occipitofrontalis_inner=1,occipitofrontalis_major=1,occipitofrontalis_outer=1");
  for (const char* brow : {"brow_left", "brow_right"}) {
    const double lifted_mm = motion(brow, 0.5).y();
    EXPECT_GE(lifted_mm, 6.0) << brow;
    EXPECT_LE(lifted_mm, 12.0) << brow;
  }
}

// By position, LLSAN ends at the wing of the nose and levator labii superioris over the lip.
TEST_F(MuscleEvidence, NoseWrinklerAndLipRaiserAreToldApart) {
  settle("9");
  const double wing = motion("nose_tip", 1.0).y();
  const double lip = motion("upper_lip", 0.75).y();
  EXPECT_GT(wing, 1.0);
  EXPECT_GT(wing, lip);
  settle("10");
  EXPECT_GT(motion("upper_lip", 0.75).y(), 2.0);
  EXPECT_GT(motion("upper_lip", 0.75).y(), motion("nose_tip", 1.0).y());
}

TEST_F(MuscleEvidence, PuckerNarrowsTheMouthAndBringsItForward) {
  settle("18");
  EXPECT_LT(motion("upper_lip", 1.0).x(), -4.0);
  EXPECT_GT(motion("upper_lip", 0.0).x(), 4.0);
  EXPECT_GT(motion("upper_lip", 0.5).z(), 2.0);
  EXPECT_GT(motion("lower_lip", 0.5).z(), 2.0);
}

TEST_F(MuscleEvidence, EveryMuscleAndEveryExpressionSettlesWithoutInversion) {
  const MuscleField field = make_muscle_field(*head_, simulator_.lattice());
  for (std::size_t m = 0; m < head_->muscles.size(); ++m) {
    const Muscle& muscle = head_->muscles[m];
    EXPECT_LT(fold_measure(muscle), 1.0) << muscle.name;
    std::vector<double> alone(head_->muscles.size(), 0.0);
    alone[m] = 1.0;
    EXPECT_EQ(num_folded(*head_, field, alone), 0) << muscle.name;
    settle(muscle.name + "=1");
  }
  for (const Expression& expression : expressions()) settle(expression.name);
  for (const ActionUnit& unit : action_units()) {
    std::string text(unit.one_sided ? "L" : "");
    settle(text += std::to_string(unit.number));
  }
}

// Figure 3d of the paper: what a frown pushes together around the mouth has to go somewhere. With
// volume preservation the skin below the corners bulges; without it the tissue crumples.
TEST(Frown, BulgesBelowTheMouthByVolumePreservation) {
  const auto head = std::make_shared<const Anatomy>(make_generic_head({}, {1000, 0, 64}));
  const Controls frown = controls_of(pose_of("corrugator_supercilii=0.8,depressor_anguli_oris=0.8,"
                                             "depressor_labii_inferioris=0.4"),
                                     *head);
  std::array<double, 2> bulge_mm{};
  std::array<SettleReport, 2> report;
  for (const int volume : {0, 1}) {
    TissueModel tissue;
    if (volume == 0) tissue.effects.clear();
    Simulator simulator(head, tissue);
    FaceState state = simulator.rest();
    report[volume] = simulator.settle(frown, state);
    for (std::size_t v = 0; v < head->region.size(); ++v) {
      const Vec3& p = head->surface.positions_mm[v];
      const bool below = std::abs(p.x()) < 45.0 && p.y() < -85.0 && p.y() > -110.0;
      if (!below || p.z() < -25.0) continue;
      bulge_mm[volume] = std::max(bulge_mm[volume], (state.positions_mm[v] - p).z());
    }
  }
  EXPECT_GT(bulge_mm[1], 0.4);
  EXPECT_LT(bulge_mm[0], 0.1);
  EXPECT_EQ(report[1].inverted_elements, 0);
  EXPECT_GT(report[0].inverted_elements, 20);
  EXPECT_LT(report[1].mean_volume_change, 0.03);
  EXPECT_GT(report[0].mean_volume_change, 0.08);
}

TEST_F(MuscleEvidence, TheJawOpensWideAndReturnsExactly) {
  Controls controls{std::vector<double>(head_->muscles.size(), 0.0), 0.0};
  FaceState state = simulator_.rest();
  for (const double degrees : {5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 20.0, 5.0, 0.0}) {
    controls.jaw_rad = degrees * kDegree;
    EXPECT_TRUE(simulator_.settle(controls, state).converged) << degrees;
  }
  double off = 0.0;
  const std::vector<Vec3>& rest = simulator_.lattice().rest_mm;
  for (std::size_t k = 0; k < rest.size(); ++k) {
    off = std::max(off, (state.positions_mm[k] - rest[k]).norm());
  }
  EXPECT_LT(off, 1e-6);
}

}  // namespace
}  // namespace zygoma
