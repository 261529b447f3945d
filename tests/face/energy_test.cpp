#include "face/energy.h"

#include <gtest/gtest.h>

#include <random>

#include "face/prism.h"
#include "face/tissue.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using test_support::FacePatchOptions;
using test_support::make_face_patch;

FacePatchOptions small_patch() {
  FacePatchOptions options;
  options.half_columns = 5;
  options.row_mm = 16.0;
  options.rows_below_mouth = 2;
  options.rows_above_mouth = 8;
  return options;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double next() { return std::uniform_real_distribution<double>(-1.0, 1.0)(engine_); }
  Vec3 vector() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }

 private:
  std::mt19937 engine_;
};

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
  FaceEnergy energy(anatomy, make_lattice(anatomy));
  std::vector<double> contraction(anatomy.muscles.size(), 0.3);
  energy.set_controls(contraction, 0.1);
  // Gently moved, compressed by half, and turned inside out here and there.
  for (const double noise_mm : {0.3, 3.0, 9.0}) {
    SCOPED_TRACE("noise " + std::to_string(noise_mm));
    Random random(17);
    std::vector<Vec3> x = energy.lattice().rest_mm;
    for (Vec3& p : x) p = 0.8 * p + noise_mm * random.vector();
    energy.place_bone(x);
    std::vector<Vec3> motion(x.size(), Vec3::Zero());
    for (int k = 0; k < energy.lattice().num_free_nodes(); ++k) motion[k] = random.vector();
    Eigen::VectorXd flat(energy.num_unknowns());
    for (Eigen::Index k = 0; k < flat.size(); ++k) flat[k] = motion[k / 3][k % 3];
    const double h = 1e-5;
    std::vector<Vec3> forward = x;
    std::vector<Vec3> backward = x;
    for (std::size_t k = 0; k < x.size(); ++k) {
      forward[k] += h * motion[k];
      backward[k] -= h * motion[k];
    }
    Eigen::VectorXd g, gf, gb;
    energy.evaluate(x, g);
    const double ef = energy.evaluate(forward, gf);
    const double eb = energy.evaluate(backward, gb);
    EXPECT_NEAR((ef - eb) / (2 * h), g.dot(flat), 1e-5 * g.norm() * flat.norm());
    const Eigen::VectorXd expected = (gf - gb) / (2 * h);
    const Eigen::VectorXd product = energy.hessian_times(x, motion);
    EXPECT_LT((product - expected).norm(), 1e-5 * expected.norm());
    // The assembled matrix is the same operator.
    ColumnMatrix hessian = energy.make_pattern();
    energy.hessian(x, hessian);
    const int n = hessian.num_columns();
    Eigen::VectorXd assembled = Eigen::VectorXd::Zero(flat.size());
    const auto row = [&](int column, int r) { return 3 * ((r / 3) * n + column) + r % 3; };
    for (int r = 0; r < hessian.rows(0); ++r) {
      for (int c = 0; c <= r; ++c) {
        for (int v = 0; v < n; ++v) {
          const double a = hessian.diagonal(v)(r, c);
          assembled[row(v, r)] += a * flat[row(v, c)];
          if (c != r) assembled[row(v, c)] += a * flat[row(v, r)];
        }
      }
    }
    for (int r = 0; r < hessian.rows(0); ++r) {
      for (int c = 0; c < hessian.rows(0); ++c) {
        for (std::size_t e = 0; e < hessian.edges.size(); ++e) {
          const double a = hessian.edge(e)(r, c);
          assembled[row(hessian.edges[e][1], r)] += a * flat[row(hessian.edges[e][0], c)];
          assembled[row(hessian.edges[e][0], c)] += a * flat[row(hessian.edges[e][1], r)];
        }
      }
    }
    EXPECT_LT((assembled - product).norm(), 1e-10 * product.norm());
  }
}

}  // namespace
}  // namespace zygoma
