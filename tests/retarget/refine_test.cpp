#include "retarget/refine.h"

#include <gtest/gtest.h>

#include <limits>

#include "src/base/check.h"
#include "tests/retarget/fake_face.h"

namespace zygoma {
namespace {

const ControlPrior kNoPast{{}, std::numeric_limits<double>::infinity()};

FrameObservation see(const FaceResponse& face, const Eigen::VectorXd& controls) {
  FrameObservation frame;
  for (int k = 0; k < kNumNodes; ++k) {
    frame.mm.col(k) = face.rest_mm.col(k) + face.displacement(k, controls.data());
  }
  frame.sigma_mm.fill(0.5);
  return frame;
}

TEST(FaceResponse, JacobianMatchesDifferences) {
  FaceResponse face = fake::make_face();
  face.jaw_cubic_mm.setLinSpaced(-1.0, 1.0);
  for (int i = 0; i < face.num_muscles(); ++i) {
    face.jaw_cross_mm.col(i).setLinSpaced(-0.1 * i, 0.3);
  }
  Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(face.num_controls(), 0.1, 0.8);
  Eigen::Matrix<double, 2, Eigen::Dynamic> jacobian(2, face.num_controls());
  for (const int node : {0, 40, 70}) {
    face.displacement(node, u.data(), &jacobian);
    for (int i = 0; i < face.num_controls(); ++i) {
      constexpr double kStep = 1e-5;
      Eigen::VectorXd plus = u;
      Eigen::VectorXd minus = u;
      plus[i] += kStep;
      minus[i] -= kStep;
      const Point2 slope =
          (face.displacement(node, plus.data()) - face.displacement(node, minus.data())) /
          (2.0 * kStep);
      EXPECT_LT((slope - jacobian.col(i)).norm(), 1e-7) << "node " << node << " control " << i;
    }
  }
}

TEST(Refiner, StaysWithinBoundsWhenThePerformerExceedsTheModel) {
  const FaceResponse face = fake::make_face();
  Eigen::VectorXd beyond = Eigen::VectorXd::Zero(face.num_controls());
  beyond[0] = 1.6;
  Refiner refiner(face, face.rest_mm);
  const RefinedFrame fit = refiner.refine(
      see(face, beyond), Eigen::VectorXd::Constant(face.num_controls(), 3.0), kNoPast);
  EXPECT_TRUE(fit.converged);
  EXPECT_LE(fit.controls.maxCoeff(), 1.0);
  EXPECT_GE(fit.controls.minCoeff(), 0.0);
  EXPECT_GT(fit.controls[0], 0.97);
}

TEST(Refiner, NothingSeenMeansThePriorAndItsSigma) {
  const FaceResponse face = fake::make_face();
  FrameObservation blind;
  Refiner refiner(face, face.rest_mm);
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(face.num_controls(), 0.5);
  const RefinedFrame fit = refiner.refine(blind, start, kNoPast);
  EXPECT_LT(fit.controls.maxCoeff(), 1e-3);
  EXPECT_NEAR(fit.sigma[0], RefineOptions{}.ridge_sigma, 1e-6);
}

TEST(Refiner, SigmaShrinksWithTheNoise) {
  const FaceResponse face = fake::make_face();
  Eigen::VectorXd controls = Eigen::VectorXd::Constant(face.num_controls(), 0.3);
  FrameObservation coarse = see(face, controls);
  FrameObservation fine = coarse;
  fine.sigma_mm.fill(0.1);
  Refiner refiner(face, face.rest_mm);
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(face.num_controls());
  const RefinedFrame a = refiner.refine(coarse, start, kNoPast);
  const RefinedFrame b = refiner.refine(fine, start, kNoPast);
  for (int i = 0; i < face.num_controls(); ++i) EXPECT_LT(b.sigma[i], a.sigma[i]) << i;
  EXPECT_LT((b.controls - controls).cwiseAbs().maxCoeff(), 0.05);
}

TEST(Refiner, ATurnedHeadIsNotAnExpression) {
  const FaceResponse face = fake::make_face();
  FrameObservation frame = see(face, Eigen::VectorXd::Zero(face.num_controls()));
  for (int k = 0; k < kNumNodes; ++k) {
    frame.mm.col(k) += 0.05 * face.yaw_motion(k) - 0.04 * face.pitch_motion(k);
  }
  Refiner refiner(face, face.rest_mm);
  const RefinedFrame fit =
      refiner.refine(frame, Eigen::VectorXd::Zero(face.num_controls()), kNoPast);
  EXPECT_LT(fit.controls.maxCoeff(), 0.05);
}

TEST(Refiner, OptionsOutOfRangeAreNamed) {
  RefineOptions options;
  options.ridge_sigma = 0.0;
  EXPECT_THROW(options.check(), InputError);
}

}  // namespace
}  // namespace zygoma
