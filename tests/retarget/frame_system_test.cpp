#include "retarget/frame_system.h"

#include <gtest/gtest.h>

#include "tests/retarget/fake_face.h"

namespace zygoma {
namespace {

// A frame with every term of the cost: an outlier, a correction, a past, antagonists, perspective.
struct Scenery {
  FaceResponse face = fake::make_face();
  ModelCorrection correction;
  FrameObservation frame;
  FrameScene scene{face, face.rest_mm, 1.0 / 900.0, RefineOptions{}};
  Eigen::VectorXd controls = Eigen::VectorXd::LinSpaced(face.num_controls(), 0.1, 0.8);
  HeadView::Parameters head{0.02, -0.01, 1.0, -0.5, 0.05, 0.03};

  Scenery() {
    for (int k = 0; k < kNumNodes; ++k) {
      frame.mm.col(k) =
          face.rest_mm.col(k) + 0.9 * face.displacement(k, controls.data()) + Point2(0.3, -0.4);
    }
    frame.mm.col(last_node(kUpperLipContour)) += Point2(9.0, 4.0);
    frame.sigma_mm.fill(0.5);
    frame.sigma_mm[kHairlineContour] = 0.0;
    correction.at = 0.5 * controls;
    correction.offset_mm = Eigen::VectorXd::LinSpaced(2 * kNumNodes, -0.2, 0.2);
    correction.slope_mm = 0.1 * Eigen::MatrixXd::Random(2 * kNumNodes, face.num_controls());
    frame.correction = &correction;
  }
};

TEST(FrameSystem, GradientIsHalfTheDerivativeOfTheCost) {
  Scenery s;
  FrameSystem system(s.scene, s.frame);
  system.lean_on({Eigen::VectorXd::Constant(s.face.num_controls(), 0.3), 0.2});
  NormalEquations equations;
  system.normal_equations(s.controls, s.head, true, equations);
  EXPECT_NEAR(equations.cost, system.cost(s.controls, s.head), 1e-9 * equations.cost);
  constexpr double kStep = 1e-6;
  const int n = s.face.num_controls();
  for (int i = 0; i < s.scene.num_unknowns(); ++i) {
    const auto cost_at = [&](double step) {
      Eigen::VectorXd u = s.controls;
      HeadView::Parameters head = s.head;
      (i < n ? u[i] : head[i - n]) += step;
      return system.cost(u, head);
    };
    const double slope = (cost_at(kStep) - cost_at(-kStep)) / (4.0 * kStep);
    EXPECT_NEAR(equations.gradient[i], slope, 1e-5 * (1.0 + std::abs(slope))) << i;
  }
  EXPECT_LT((equations.information - equations.information.transpose()).norm(), 1e-9);
}

TEST(FrameSystem, ReducedResidualsHaveTheSameNormalEquations) {
  Scenery s;
  const FrameSystem system(s.scene, s.frame);
  NormalEquations equations;
  system.normal_equations(s.controls, s.head, true, equations);
  Eigen::LDLT<Eigen::MatrixXd> factor;
  Eigen::VectorXd residual;
  Eigen::MatrixXd root;
  reduce(equations, factor, residual, root);
  const Eigen::Index n = s.scene.num_unknowns();
  ASSERT_EQ(residual.size(), n + 1);
  const double size = equations.information.norm();
  EXPECT_LT((root.transpose() * root - equations.information).norm(), 1e-12 * size);
  EXPECT_LT((root.transpose() * residual.head(n) - equations.gradient).norm(),
            1e-10 * equations.gradient.norm());
  EXPECT_NEAR(residual.squaredNorm(), equations.cost, 1e-10 * equations.cost);
}

}  // namespace
}  // namespace zygoma
