#include "retarget/jaw_carry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "retarget/retarget.h"
#include "tests/retarget/fake_face.h"

namespace zygoma {
namespace {

constexpr double kFrame_s = 0.04;

// A jaw that takes the corners of the mouth down with it.
FaceResponse model() {
  FaceResponse face = fake::make_face();
  const double half_mm = face.rest_mm(0, last_node(kUpperLipContour));
  for (const int contour : {kUpperLipContour, kLowerLipContour}) {
    for (int k = first_node(contour); k <= last_node(contour); ++k) {
      const double across = face.rest_mm(0, k) / half_mm;
      face.linear_mm.rightCols<1>()[2 * k + 1] += 14.0 * across * across;
    }
  }
  return face;
}

// Rest, then a mouth that opens and closes, now and then with a smile.
std::vector<ContourSet> speak(const FaceResponse& face, bool with_smile) {
  std::vector<ContourSet> clip;
  const auto& names = face.muscles;
  for (int t = 0; t < 100; ++t) {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(face.num_controls());
    const double s = std::max(0.0, t * kFrame_s - 0.8);
    u[u.size() - 1] = 0.4 * std::pow(std::sin(5.0 * s), 2);
    for (int i = 0; i < face.num_muscles(); ++i) {
      const bool smiles = names[static_cast<std::size_t>(i)].starts_with("zygomaticus");
      if (with_smile && smiles) u[i] = 0.5 * std::pow(std::sin(1.7 * s), 2);
    }
    clip.push_back(fake::observe(face, u, fake::camera(1.2), t, t * kFrame_s));
  }
  return clip;
}

double largest_smile(const ContractionTrack& track) {
  double largest = 0.0;
  for (const Contractions& frame : track.frames) {
    for (std::size_t i = 0; i < track.muscles.size(); ++i) {
      if (track.muscles[i].starts_with("zygomaticus")) largest = std::max(largest, frame.value[i]);
    }
  }
  return largest;
}

TEST(JawCarry, ScalesTheCornersAndNothingElse) {
  const FaceResponse face = model();
  const FaceResponse other = with_jaw_carry(face, 0.5);
  Eigen::VectorXd u = Eigen::VectorXd::Constant(face.num_controls(), 0.3);
  for (const int corner : {first_node(kUpperLipContour), last_node(kLowerLipContour)}) {
    EXPECT_NEAR(other.linear_mm.rightCols<1>()[2 * corner + 1],
                0.5 * face.linear_mm.rightCols<1>()[2 * corner + 1],
                1e-12);
  }
  for (int k = 0; k < kNumNodes; ++k) {
    const bool is_lip = (k >= first_node(kUpperLipContour) && k <= last_node(kLowerLipContour));
    const Point2 change = other.displacement(k, u.data()) - face.displacement(k, u.data());
    if (!is_lip) {
      EXPECT_EQ(change.norm(), 0.0) << k;
    }
  }
  u[face.num_controls() - 1] = 0.0;
  for (int k = 0; k < kNumNodes; ++k) {
    EXPECT_EQ(other.displacement(k, u.data()), face.displacement(k, u.data())) << k;
  }
}

TEST(JawCarry, IsFoundAndKeepsTheSmileOutOfAnOpenMouth) {
  const FaceResponse face = model();
  for (const double carry : {0.5, 0.75, 1.0, 1.25}) {
    const FaceResponse performer = with_jaw_carry(face, carry);
    for (const bool live : {false, true}) {
      RetargetOptions options;
      options.causal = live;
      RetargetReport report;
      const ContractionTrack track = retarget(speak(performer, false), {face}, options, report);
      EXPECT_NEAR(report.jaw_carry, carry, 0.15) << live;
      EXPECT_LT(largest_smile(track), 0.05) << carry << " " << live;
      retarget(speak(performer, true), {face}, options, report);
      EXPECT_NEAR(report.jaw_carry, carry, 0.2) << live;
    }
  }
}

TEST(JawCarry, IsTheModelsWhereNothingTellsOrAllIsTrusted) {
  const FaceResponse face = model();
  std::vector<ContourSet> still(30, speak(face, false).front());
  for (int t = 0; t < 30; ++t) {
    still[static_cast<std::size_t>(t)].frame_index = t;
    still[static_cast<std::size_t>(t)].time_s = t * kFrame_s;
  }
  RetargetReport report;
  retarget(still, {face}, {}, report);
  EXPECT_EQ(report.jaw_carry, 1.0);
  RetargetOptions trusting;
  trusting.refinement.relative_error = 0.0;
  retarget(speak(with_jaw_carry(face, 0.5), false), {face}, trusting, report);
  EXPECT_EQ(report.jaw_carry, 1.0);
}

}  // namespace
}  // namespace zygoma
