#include "face/energy.h"

#include <gtest/gtest.h>

#include <array>

#include "face/prism.h"
#include "face/tissue.h"
#include "tests/support/derivatives.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::flattened;
using test_support::HessianProduct;
using test_support::make_face_patch;
using test_support::Random;
using test_support::times;

FacePatchOptions small_patch() {
  FacePatchOptions options;
  options.half_columns = 5;
  options.row_mm = 16.0;
  options.rows_below_mouth = 2;
  options.rows_above_mouth = 8;
  return options;
}

TEST(Spring, StretchedPullsItsEndsTogetherCompressedPushesThemApart) {
  const Spring spring = make_spring(0, 1, Vec3::Zero(), Vec3(20.0, 0.0, 0.0), 3.0, 4.0);
  Vec3 at_end;  // d(energy)/d(xj); the force on j is minus that
  spring_energy(spring, Vec3(22.0, 0.0, 0.0), at_end);
  EXPECT_NEAR(-at_end.x(), -3.0 * 2.0, 1e-3 * 6.0);
  spring_energy(spring, Vec3(18.0, 0.0, 0.0), at_end);
  EXPECT_GT(-at_end.x(), 0.0);
  EXPECT_LT(-at_end.x(), 0.5 * 3.0 * 2.0) << "collagen in compression is slack";
  spring_energy(spring, Vec3(20.0, 0.0, 0.0), at_end);
  EXPECT_EQ(at_end, Vec3::Zero());
}

TEST(Spring, BiphasicForceIsTheContinuousLawOutsideTheBand) {
  const BiphasicLaw law{2.0, 6.0, 0.3, 0.04};
  EXPECT_DOUBLE_EQ(respond(law, 0.2).force, 0.4);
  EXPECT_DOUBLE_EQ(respond(law, 0.5).force, 1.0 + 6.0 * 0.2);
  EXPECT_DOUBLE_EQ(respond(law, 0.5).stiffness, 8.0);
  // Energy and stiffness are integral and derivative of the force, also across the band.
  for (double e = 0.2; e < 0.4; e += 0.003) {
    const double h = 1e-5;
    EXPECT_NEAR((respond(law, e + h).energy - respond(law, e - h).energy) / (2 * h),
                respond(law, e).force,
                1e-8);
    EXPECT_NEAR((respond(law, e + h).force - respond(law, e - h).force) / (2 * h),
                respond(law, e).stiffness,
                2e-6);
  }
}

TEST(Spring, ForceFallsToTheSlackStiffnessInCompression) {
  const BiphasicLaw law{2.0, 0.0, 0.0, 0.0, 1.8, 0.05};
  EXPECT_DOUBLE_EQ(respond(law, 0.1).force, 0.2);
  EXPECT_DOUBLE_EQ(respond(law, 0.0).force, 0.0);
  EXPECT_DOUBLE_EQ(respond(law, 0.0).stiffness, 2.0);
  // Below the band: the force that the band itself took, then alpha_c.
  EXPECT_NEAR(respond(law, -0.5).stiffness, 0.2, 1e-12);
  EXPECT_NEAR(respond(law, -0.5).force, -2.0 * 0.05 - 0.2 * 0.45, 1e-12);
  for (double e = -0.2; e < 0.05; e += 0.003) {
    const double h = 1e-5;
    EXPECT_NEAR((respond(law, e + h).energy - respond(law, e - h).energy) / (2 * h),
                respond(law, e).force,
                1e-8);
    EXPECT_NEAR((respond(law, e + h).force - respond(law, e - h).force) / (2 * h),
                respond(law, e).stiffness,
                2e-6);
  }
}

TEST(Spring, FiniteAtZeroLength) {
  const Spring spring = make_spring(0, 1, Vec3::Zero(), Vec3(2.0, 0.0, 0.0), 3.0, 4.0);
  Vec3 g;
  EXPECT_TRUE(std::isfinite(spring_energy(spring, Vec3::Zero(), g)));
  EXPECT_EQ(g, Vec3::Zero());
  EXPECT_TRUE(spring_hessian(spring, Vec3::Zero()).allFinite());
  const Spring coincident = make_spring(0, 1, Vec3::Ones(), Vec3::Ones(), 3.0, 4.0);
  EXPECT_TRUE(spring_hessian(coincident, Vec3::Zero()).allFinite());
}

TEST(Prism, VolumeOfABoxHalfAndOfItsMirrorImage) {
  const PrismCorners prism{
      Vec3(0, 0, 1), Vec3(2, 0, 1), Vec3(0, 3, 1), Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, 0)};
  PrismCorners g;
  EXPECT_NEAR(prism_volume(prism, g), 3.0, 1e-14);
  const PrismCorners inverted{prism[3], prism[4], prism[5], prism[0], prism[1], prism[2]};
  EXPECT_NEAR(prism_volume(inverted, g), -3.0, 1e-14);
}

TEST(Prism, VolumeIsTheMeanOfTheTwoSplits) {
  Random random(3);
  const auto tet = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return (b - a).cross(c - a).dot(a - d) / 6.0;
  };
  for (int trial = 0; trial < 20; ++trial) {
    PrismCorners x;
    for (Vec3& corner : x) corner = random.vector();
    // Two complementary splits: upper corners taken in one turn and in the other.
    const double one =
        tet(x[0], x[1], x[2], x[3]) + tet(x[3], x[1], x[2], x[4]) + tet(x[3], x[4], x[2], x[5]);
    const double other =
        tet(x[0], x[1], x[2], x[5]) + tet(x[0], x[1], x[5], x[4]) + tet(x[0], x[4], x[5], x[3]);
    PrismCorners g;
    EXPECT_NEAR(prism_volume(x, g), 0.5 * (one + other), 1e-12);
  }
}

TEST(FaceEnergy, GradientAndHessianMatchCentralDifferences) {
  const Anatomy anatomy = make_face_patch(small_patch());
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    TissueModel model;
    model.lattice.topology = topology;
    FaceEnergy energy(anatomy, model);
    std::vector<double> contraction(anatomy.muscles.size(), 0.3);
    energy.set_controls(contraction, 0.1);
    // Gently moved, compressed by half, and turned inside out here and there.
    for (const double noise_mm : {0.3, 3.0, 9.0}) {
      SCOPED_TRACE("topology " + std::to_string(static_cast<int>(topology)) + ", noise " +
                   std::to_string(noise_mm));
      Random random(17);
      std::vector<Vec3> x = energy.lattice().rest_mm;
      for (Vec3& p : x) p = 0.8 * p + noise_mm * random.vector();
      energy.place_bone(x);
      std::vector<Vec3> motion(x.size(), Vec3::Zero());
      for (int k = 0; k < energy.lattice().num_free_nodes; ++k) motion[k] = random.vector();
      const double h = 1e-5;
      std::vector<Vec3> forward = x;
      std::vector<Vec3> backward = x;
      for (std::size_t k = 0; k < x.size(); ++k) {
        forward[k] += h * motion[k];
        backward[k] -= h * motion[k];
      }
      const Eigen::VectorXd flat = flattened(motion);
      Eigen::VectorXd g, gf, gb;
      energy.evaluate(x, g);
      const double ef = energy.evaluate(forward, gf);
      const double eb = energy.evaluate(backward, gb);
      EXPECT_NEAR((ef - eb) / (2 * h), g.dot(flat), 1e-5 * g.norm() * flat.norm());
      const Eigen::Index n = energy.num_unknowns();
      const Eigen::VectorXd expected = ((gf - gb) / (2 * h)).head(n);
      HessianProduct product(motion);
      energy.add_hessian(x, product);
      EXPECT_LT((product.result.head(n) - expected).norm(), 1e-5 * expected.norm());
      // The assembled matrix is the same operator.
      TissueHessian hessian = energy.make_hessian();
      energy.hessian(x, hessian);
      const Eigen::VectorXd assembled = times(hessian.free(), flat.head(n));
      EXPECT_LT((assembled - product.result.head(n)).norm(), 1e-10 * expected.norm());
    }
  }
}

TEST(FaceEnergy, BoneMovesTheFreeNodesAsTheHessianSays) {
  const Anatomy anatomy = make_face_patch(small_patch());
  FaceEnergy energy(anatomy);
  const std::vector<double> contraction(anatomy.muscles.size(), 0.2);
  energy.set_controls(contraction, 0.15);
  Random random(4);
  std::vector<Vec3> x = energy.lattice().rest_mm;
  for (Vec3& p : x) p += 0.4 * random.vector();
  energy.place_bone(x);
  TissueHessian hessian = energy.make_hessian();
  energy.hessian(x, hessian);
  const Eigen::MatrixXd forces = energy.control_forces(x, hessian);
  const int jaw = static_cast<int>(contraction.size());
  for (const int control : {2, 9, jaw}) {
    const double h = 1e-5;
    std::array<Eigen::VectorXd, 2> gradient;
    for (const int side : {0, 1}) {
      std::vector<double> c = contraction;
      double jaw_rad = 0.15;
      (control == jaw ? jaw_rad : c[control]) += side == 0 ? -h : h;
      energy.set_controls(c, jaw_rad);
      std::vector<Vec3> moved = x;
      energy.place_bone(moved);
      energy.evaluate(moved, gradient[side]);
    }
    const Eigen::VectorXd expected =
        (-(gradient[1] - gradient[0]) / (2 * h)).head(energy.num_unknowns());
    EXPECT_LT((forces.col(control) - expected).norm(), 1e-5 * expected.norm()) << control;
  }
}

}  // namespace
}  // namespace zygoma
