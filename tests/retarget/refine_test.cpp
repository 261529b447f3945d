#include "retarget/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
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

RefinedFrame begin_at(const Eigen::VectorXd& controls) {
  RefinedFrame start;
  start.controls = controls;
  return start;
}

RefinedFrame at_rest(const FaceResponse& face) {
  return begin_at(Eigen::VectorXd::Zero(face.num_controls()));
}

TEST(FaceResponse, SlopeMatchesDifferences) {
  FaceResponse face = fake::make_face();
  face.cubic_mm = Eigen::MatrixXd::Random(2 * kNumNodes, face.num_controls());
  face.pairs = {{0, 3}, {2, face.num_muscles()}};
  face.pair_mm = Eigen::MatrixXd::Random(2 * kNumNodes, 2);
  const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(face.num_controls(), 0.1, 0.8);
  Eigen::VectorXd here;
  Eigen::VectorXd before;
  Eigen::VectorXd after;
  Eigen::MatrixXd slope;
  face.displace(u, here, &slope);
  for (int i = 0; i < face.num_controls(); ++i) {
    constexpr double kStep = 1e-5;
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(face.num_controls(), i);
    face.displace(u + step, after);
    face.displace(u - step, before);
    EXPECT_LT(((after - before) / (2.0 * kStep) - slope.col(i)).norm(), 1e-6) << i;
  }
  for (const int node : {0, 40, 70}) {
    EXPECT_LT((face.displacement(node, u.data()) - here.segment<2>(2 * node)).norm(), 1e-12);
  }
}

TEST(FaceResponse, LinearisedMeetsTheResponseAtHalfStrength) {
  const FaceResponse face = fake::make_face();
  Eigen::VectorXd full;
  Eigen::VectorXd line;
  const Eigen::VectorXd half = 0.5 * Eigen::VectorXd::Unit(face.num_controls(), 2);
  face.displace(half, full);
  face.linearised().displace(half, line);
  EXPECT_LT((full - line).norm(), 1e-12);
  face.linearised().displace(2.0 * half, line);
  EXPECT_LT((2.0 * full - line).norm(), 1e-12);
}

TEST(FaceResponse, AScaledPerformerGoesAsFarWithLess) {
  FaceResponse face = fake::make_face();
  face.quadratic_mm.setZero();
  const Eigen::VectorXd gain = Eigen::VectorXd::Constant(face.num_controls(), 2.0);
  const Eigen::VectorXd u = Eigen::VectorXd::Constant(face.num_controls(), 0.3);
  Eigen::VectorXd strong;
  Eigen::VectorXd usual;
  face.scaled(gain).displace(u, strong);
  face.displace(2.0 * u, usual);
  EXPECT_LT((strong - usual).norm(), 1e-12);
}

TEST(HeadView, DerivativesMatchDifferences) {
  for (const double inverse_distance : {0.0, 1.0 / 700.0}) {
    const Point2 q(20.0, -40.0);
    constexpr double kDepth_mm = 25.0;
    constexpr double kStep = 1e-6;
    HeadView::Parameters head;
    head << 0.1, 0.2, 3.0, 4.0, 0.3, -0.2;
    const auto at = [&](const Point2& node, const HeadView::Parameters& h) {
      return HeadView(h, inverse_distance).see(node, kDepth_mm).at;
    };
    const HeadView::Sight sight = HeadView(head, inverse_distance).see(q, kDepth_mm);
    for (int i = 0; i < HeadView::kNumParameters; ++i) {
      const HeadView::Parameters step = kStep * HeadView::Parameters::Unit(i);
      const Point2 slope = (at(q, head + step) - at(q, head - step)) / (2.0 * kStep);
      EXPECT_LT((slope - sight.by_head.col(i)).norm(), 1e-7) << i;
    }
    for (int i = 0; i < 2; ++i) {
      const Point2 step = kStep * Point2::Unit(i);
      const Point2 slope = (at(q + step, head) - at(q - step, head)) / (2.0 * kStep);
      EXPECT_LT((slope - sight.by_node.col(i)).norm(), 1e-7) << i;
    }
    EXPECT_LT((at(q, HeadView::Parameters::Zero()) - q).norm(), 1e-12);
  }
}

TEST(Refiner, StaysWithinBoundsWhenThePerformerExceedsTheModel) {
  const FaceResponse face = fake::make_face();
  Eigen::VectorXd beyond = Eigen::VectorXd::Zero(face.num_controls());
  beyond[0] = 1.8;
  Refiner refiner(face, face.rest_mm);
  const RefinedFrame fit = refiner.refine(
      see(face, beyond), begin_at(Eigen::VectorXd::Constant(face.num_controls(), 3.0)), kNoPast);
  EXPECT_TRUE(fit.converged);
  EXPECT_LE(fit.controls.maxCoeff(), 1.0);
  EXPECT_GE(fit.controls.minCoeff(), 0.0);
  EXPECT_GT(fit.controls[0], 0.97);
}

TEST(Refiner, NothingSeenMeansThePriorAndItsSigma) {
  const FaceResponse face = fake::make_face();
  FrameObservation blind;
  Refiner refiner(face, face.rest_mm);
  const RefinedFrame fit =
      refiner.refine(blind, begin_at(Eigen::VectorXd::Constant(face.num_controls(), 0.5)), kNoPast);
  EXPECT_LT(fit.controls.maxCoeff(), 1e-3);
  const FramePosterior posterior = refiner.posterior(blind, fit);
  EXPECT_NEAR(posterior.sigma[0], RefineOptions{}.ridge_sigma, 1e-6);
  EXPECT_LT((posterior.sigma - posterior.prior_sigma).norm(), 1e-12);
  EXPECT_EQ(posterior.influence.norm(), 0.0);
}

TEST(Refiner, SigmaShrinksWithTheNoise) {
  const FaceResponse face = fake::make_face();
  const Eigen::VectorXd controls = Eigen::VectorXd::Constant(face.num_controls(), 0.3);
  RefineOptions options;
  options.relative_error = 0.0;
  Refiner refiner(face, face.rest_mm, 0.0, options);
  const FrameObservation coarse = see(face, controls);
  FrameObservation fine = coarse;
  fine.sigma_mm.fill(0.1);
  const RefinedFrame a = refiner.refine(coarse, at_rest(face), kNoPast);
  const RefinedFrame b = refiner.refine(fine, at_rest(face), kNoPast);
  const Eigen::VectorXd wide = refiner.posterior(coarse, a).sigma;
  const Eigen::VectorXd narrow = refiner.posterior(fine, b).sigma;
  for (int i = 0; i < face.num_controls(); ++i) EXPECT_LT(narrow[i], wide[i]) << i;
  EXPECT_LT((b.controls - controls).cwiseAbs().maxCoeff(), 0.05);
}

TEST(Refiner, InfluenceNamesTheContourThatShowsAMuscle) {
  const FaceResponse face = fake::make_face();
  Refiner refiner(face, face.rest_mm);
  const FrameObservation frame = see(face, Eigen::VectorXd::Zero(face.num_controls()));
  const Eigen::MatrixXd influence =
      refiner.posterior(frame, refiner.refine(frame, at_rest(face), kNoPast)).influence;
  const auto strongest = [&](const std::string& name) {
    const auto at = std::find(face.muscles.begin(), face.muscles.end(), name);
    Eigen::Index contour = 0;
    influence.row(at - face.muscles.begin()).maxCoeff(&contour);
    return static_cast<int>(contour);
  };
  EXPECT_EQ(strongest("occipitofrontalis_outer_L"), kBrowLeftContour);
  EXPECT_EQ(strongest("occipitofrontalis_outer_R"), kBrowRightContour);
  EXPECT_EQ(strongest("levator_labii_superioris_alaeque_nasi_L"), kFurrowLeftContour);
}

TEST(Refiner, ATurnedHeadIsNotAnExpression) {
  const FaceResponse face = fake::make_face();
  FrameObservation frame = see(face, Eigen::VectorXd::Zero(face.num_controls()));
  HeadView::Parameters head = HeadView::Parameters::Zero();
  head[4] = 0.05;
  head[5] = -0.04;
  for (int k = 0; k < kNumNodes; ++k) {
    frame.mm.col(k) = HeadView(head).see(frame.mm.col(k), face.rest_depth_mm[k]).at;
  }
  Refiner refiner(face, face.rest_mm);
  const RefinedFrame fit = refiner.refine(frame, at_rest(face), kNoPast);
  EXPECT_LT(fit.controls.maxCoeff(), 0.05);
  EXPECT_NEAR(fit.head[4], 0.05, 0.03);
}

TEST(Refiner, AWindowBringsAStrayFrameBackToItsNeighbours) {
  const FaceResponse face = fake::make_face();
  const Eigen::VectorXd held = 0.4 * Eigen::VectorXd::Unit(face.num_controls(), 0);
  std::vector<FrameObservation> frames;
  std::vector<RefinedFrame> solved;
  Refiner refiner(face, face.rest_mm);
  for (int t = 0; t < 9; ++t) {
    frames.push_back(see(face, held));
    frames.back().time_s = t / 30.0;
    if (t == 4) {
      for (int k = first_node(kUpperLipContour); k <= last_node(kUpperLipContour); ++k) {
        frames.back().mm.col(k) += Point2(0.0, -3.0);
      }
    }
    solved.push_back(refiner.refine(frames.back(), at_rest(face), kNoPast));
  }
  const double alone = std::abs(solved[4].controls[0] - held[0]);
  refiner.refine_window(frames, solved, 0);
  EXPECT_LT(std::abs(solved[4].controls[0] - held[0]), 0.6 * alone);
  for (const RefinedFrame& frame : solved) EXPECT_TRUE(frame.converged);
}

TEST(Refiner, OptionsOutOfRangeAreNamed) {
  RefineOptions options;
  options.ridge_sigma = 0.0;
  EXPECT_THROW(options.check(), InputError);
}

}  // namespace
}  // namespace zygoma
