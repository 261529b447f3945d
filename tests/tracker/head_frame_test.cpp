#include "tracker/head_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zygoma {
namespace {

std::vector<Point2> scattered() {
  std::vector<Point2> points;
  for (int i = 0; i < 20; ++i)
    points.emplace_back(13.0 * (i % 5) + i, 17.0 * (i / 5) - 0.3 * i * i);
  return points;
}

TEST(HeadFrame, RecoversASimilarityExactlyDespiteOutliers) {
  const Similarity truth{1.1 * std::cos(0.3), 1.1 * std::sin(0.3), Point2(12.0, -7.0)};
  const std::vector<Point2> from = scattered();
  std::vector<Point2> to;
  for (const Point2& p : from) to.push_back(truth.apply(p));
  to[3] += Point2(40.0, -10.0);
  to[11] += Point2(-6.0, 5.0);
  to[17] += Point2(0.0, 9.0);
  const HeadFrameFit fit = fit_head_frame(from, to);
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.similarity.a, truth.a, 1e-9);
  EXPECT_NEAR(fit.similarity.b, truth.b, 1e-9);
  EXPECT_LT((fit.similarity.shift - truth.shift).norm(), 1e-7);
  EXPECT_NEAR(fit.inlier_share, 17.0 / 20.0, 1e-12);
}

TEST(HeadFrame, InverseAndCompositionAreExact) {
  const Similarity s{0.9, -0.2, Point2(3.0, 4.0)};
  const Similarity t{1.3, 0.4, Point2(-5.0, 1.0)};
  const Point2 p(7.0, -2.0);
  EXPECT_LT((s.inverse().apply(s.apply(p)) - p).norm(), 1e-12);
  EXPECT_LT((s.after(t).apply(p) - s.apply(t.apply(p))).norm(), 1e-12);
}

TEST(HeadFrame, SaysSoWhenThereIsNothingToFit) {
  EXPECT_FALSE(fit_head_frame({}, {}).ok);
  const std::vector<Point2> same(10, Point2(5.0, 5.0));
  EXPECT_FALSE(fit_head_frame(same, same).ok);
}

}  // namespace
}  // namespace zygoma
