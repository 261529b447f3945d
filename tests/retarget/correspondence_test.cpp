#include "retarget/correspondence.h"

#include <gtest/gtest.h>

#include <limits>

#include "src/base/check.h"

namespace zygoma {
namespace {

TEST(Correspondence, StackHoldsAllSchemaNodesInOrder) {
  EXPECT_EQ(kNumNodes, 93 + 2 * 9);  // the nine of the paper, and the lids
  EXPECT_EQ(first_node(kBrowLeftContour), 0);
  EXPECT_EQ(last_node(kHairlineContour), 92);
  EXPECT_EQ(last_node(kNumContours - 1), kNumNodes - 1);
  for (int c = 0; c + 1 < kNumContours; ++c) EXPECT_EQ(last_node(c) + 1, first_node(c + 1));
}

TEST(Correspondence, ResamplingAStraightLineIsEven) {
  const std::vector<Point2> line{{0, 0}, {1, 0}, {1, 0}, {5, 0}, {8, 0}};
  const std::vector<Point2> even = resample_by_arc_length(line, 9);
  for (int k = 0; k < 9; ++k) {
    EXPECT_NEAR(even[static_cast<std::size_t>(k)].x(), k, 1e-12);
    EXPECT_EQ(even[static_cast<std::size_t>(k)].y(), 0.0);
  }
}

TEST(Correspondence, ResamplingKeepsEndsAndCollapsedContours) {
  const std::vector<Point2> point{{3, 4}, {3, 4}, {3, 4}};
  for (const Point2& p : resample_by_arc_length(point, 5)) EXPECT_EQ(p, Point2(3, 4));
  const std::vector<Point2> bent{{0, 0}, {3, 0}, {3, 1}};
  const std::vector<Point2> even = resample_by_arc_length(bent, 4);
  EXPECT_EQ(even.front(), bent.front());
  EXPECT_EQ(even.back(), bent.back());
}

TEST(Correspondence, ResampledVelocityIsTheDerivative) {
  const std::vector<Point2> curve{{0, 0}, {2, 1}, {3, 4}, {7, 5}, {9, 2}};
  const std::vector<Point2> velocity{{1, -1}, {0.5, 2}, {-1, 0.3}, {0.2, 0.7}, {1.5, -0.4}};
  std::vector<Point2> points(7);
  std::vector<Point2> rate;
  resample_by_arc_length(curve, velocity, points, rate);
  constexpr double kStep = 1e-6;
  std::vector<Point2> ahead = curve;
  std::vector<Point2> behind = curve;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    ahead[i] += kStep * velocity[i];
    behind[i] -= kStep * velocity[i];
  }
  const std::vector<Point2> plus = resample_by_arc_length(ahead, 7);
  const std::vector<Point2> minus = resample_by_arc_length(behind, 7);
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_LT((rate[k] - (plus[k] - minus[k]) / (2.0 * kStep)).norm(), 1e-7) << "node " << k;
  }
}

TEST(Correspondence, NonFinitePointsAreRefusedByName) {
  ContourSet set;
  set.frame_index = 12;
  for (const Feature& feature : kFeatureSchema) {
    set.contours.push_back({std::string(feature.name), {{0, 0}, {1, 1}}, 1.0, false});
  }
  set.contours[4].points_px[1].x() = std::numeric_limits<double>::quiet_NaN();
  try {
    stack_contours(set);
    FAIL() << "accepted a point that is not finite";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("frame 12"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("nose_tip"), std::string::npos);
  }
}

TEST(Correspondence, LostContoursAreInvisible) {
  ContourSet set;
  for (const Feature& feature : kFeatureSchema) {
    set.contours.push_back({std::string(feature.name), {{0, 0}, {1, 1}}, 0.5, false});
  }
  set.contours[0].points_px.clear();
  set.contours[0].confidence = 0.0;
  const StackedContours stack = stack_contours(set);
  EXPECT_FALSE(stack.visible(kBrowLeftContour));
  EXPECT_EQ(stack.num_visible(), kNumContours - 1);
}

}  // namespace
}  // namespace zygoma
