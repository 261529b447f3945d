#include "retarget/head_motion.h"

#include <gtest/gtest.h>

#include "tests/retarget/fake_face.h"

namespace zygoma {
namespace {

TEST(HeadMotion, InverseAndProductUndoEachOther) {
  const HeadMotion motion = fake::camera(1.7, 0.4, {12.0, -7.0});
  const Point2 p(31.0, 8.0);
  EXPECT_LT((motion.inverse() * (motion * p) - p).norm(), 1e-12);
  const HeadMotion twice = motion * motion;
  EXPECT_LT((twice * p - motion * (motion * p)).norm(), 1e-12);
  EXPECT_NEAR(twice.roll_rad(), 0.8, 1e-12);
  EXPECT_NEAR(twice.scale(), 1.7 * 1.7, 1e-12);
}

TEST(HeadMotion, FitRecoversASimilarityExactly) {
  const NodeStack from = fake::make_face().rest_mm;
  const HeadMotion truth = fake::camera(2.3, -0.3, {200.0, 100.0});
  NodeStack to;
  for (int k = 0; k < kNumNodes; ++k) to.col(k) = truth * Point2(from.col(k));
  const HeadMotion fit = fit_head_motion(from, to, Eigen::VectorXd::Ones(kNumNodes));
  EXPECT_NEAR(fit.a, truth.a, 1e-12);
  EXPECT_NEAR(fit.b, truth.b, 1e-12);
  EXPECT_LT((fit.shift - truth.shift).norm(), 1e-9);
}

TEST(HeadMotion, DisturbedHairlineNodesFadeOut) {
  StackedContours neutral;
  neutral.nodes = fake::make_face().rest_mm;
  neutral.confidence.fill(1.0);
  StackedContours frame = neutral;
  for (int k = 0; k < 4; ++k) frame.nodes.col(first_node(kHairlineContour) + k).y() += 12.0;
  const HeadMotion fit =
      fit_head_motion_robustly(neutral.nodes, frame.nodes, head_weights(neutral, frame), 1.0);
  EXPECT_NEAR(fit.scale(), 1.0, 2e-3);
  EXPECT_NEAR(fit.roll_rad(), 0.0, 2e-3);
  EXPECT_LT(fit.shift.norm(), 0.2);
}

}  // namespace
}  // namespace zygoma
