#include "tracker/potential_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "tracker/snake.h"

namespace zygoma {
namespace {

// A dark band between two heights, edges smooth: its upper edge is where brightness falls
// downwards.
cv::Mat dark_band(double top, double bottom) {
  cv::Mat image(80, 120, CV_8U);
  for (int row = 0; row < image.rows; ++row) {
    const auto step = [row](double at) { return 0.5 * (1.0 + std::erf((row - at) / 1.4)); };
    const double value = 200.0 - 120.0 * (step(top) - step(bottom));
    image.row(row).setTo(cv::Scalar(std::round(value)));
  }
  return image;
}

class FieldLandscape : public ImageLandscape {
 public:
  FieldLandscape(const PotentialField& field, const Point2& normal)
      : field_(field), normal_(normal) {}
  double potential(size_t, const Point2& x) const override { return field_.potential(x, normal_); }
  Point2 gradient(size_t, const Point2& x) const override { return field_.gradient(x, normal_); }

 private:
  const PotentialField& field_;
  Point2 normal_;
};

TEST(PotentialField, RavineLiesOnTheEdge) {
  const PotentialField field(dark_band(30.4, 50.0), cv::Rect(0, 0, 120, 80), {1.5, 0.95, 1.0});
  double best = 0.0;
  double at = 0.0;
  for (double y = 20.0; y < 40.0; y += 0.05) {
    if (field.potential({60.0, y}) < best) {
      best = field.potential({60.0, y});
      at = y;
    }
  }
  EXPECT_NEAR(at, 30.4, 0.5);  // the magnitude itself is linear between rows
  EXPECT_LT(best, -0.5);
}

TEST(PotentialField, SnakeFindsTheEdgeItWasGiven) {
  const PotentialField field(dark_band(30.4, 38.0), cv::Rect(0, 0, 120, 80), {1.5, 0.95, 1.0});
  for (const auto& [normal_y, edge] : {std::pair{-1.0, 30.4}, std::pair{1.0, 38.0}}) {
    std::vector<Point2> nodes;
    for (int i = 0; i < 9; ++i) nodes.emplace_back(30.0 + 6.0 * i, 34.2 + 1.0 * normal_y);
    SnakeOptions options;
    options.max_iterations = 400;
    options.tolerance_px = 1e-4;
    Snake snake(nodes, options);
    snake.relax(nullptr);
    const FieldLandscape landscape(field, Point2(0.0, normal_y));
    snake.relax(&landscape);
    for (const Point2& p : snake.nodes()) {
      EXPECT_NEAR(p.y(), edge, 0.05);
      EXPECT_EQ(field.potential(p, Point2(0.0, -normal_y)), 0.0);  // the other edge's ravine
    }
  }
}

// A contour rests where the gradient vanishes: between pixels, not on them, and without jumps as it
// passes from one pixel to the next.
TEST(PotentialField, GradientFindsTheEdgeBetweenPixels) {
  for (const double edge : {30.0, 30.2, 30.4, 30.5, 30.7, 30.9}) {
    const PotentialField field(dark_band(edge, 50.0), cv::Rect(0, 0, 120, 80), {1.5, 0.95, 1.0});
    double rest = 0.0;
    double steepest = 0.0;
    constexpr double kStep = 0.01;
    for (double y = 28.0; y < 33.0; y += kStep) {
      const double here = field.gradient({60.3, y}).y();
      const double next = field.gradient({60.3, y + kStep}).y();
      steepest = std::max(steepest, std::abs(next - here) / kStep);
      if (here < 0.0 && next >= 0.0) rest = y + 0.5 * kStep;
    }
    EXPECT_NEAR(rest, edge, 0.05);
    EXPECT_LT(steepest, 1.0);  // 1 / (1.5^2 + 1.4^2) of a smooth ravine one deep, with room
  }
}

TEST(PotentialField, NothingOutsideTheRegionIsLookedAt) {
  cv::Mat image = dark_band(30.4, 50.0);
  const cv::Rect region(30, 15, 60, 30);
  const PotentialField before(image, region, {});
  // Beyond the region and the reach of its Gaussian.
  image.rowRange(60, 80).setTo(cv::Scalar(7));
  image.colRange(0, 20).setTo(cv::Scalar(250));
  const PotentialField after(image, region, {});
  for (double y = 16.0; y < 44.0; y += 0.7) {
    EXPECT_EQ(before.potential({55.5, y}), after.potential({55.5, y}));
    EXPECT_EQ(before.gradient({55.5, y}), after.gradient({55.5, y}));
    EXPECT_EQ(after.gradient({5.0, y}), Point2::Zero());
  }
}

TEST(PotentialField, CutOutEqualsTheWhole) {
  const cv::Mat image = dark_band(30.4, 50.0);
  PotentialOptions options;
  options.percentile = 1.0;
  const PotentialField whole(image, cv::Rect(0, 0, 120, 80), options);
  const PotentialField part(image, cv::Rect(20, 10, 60, 60), options);
  const Point2 x(50.3, 31.2);
  EXPECT_NEAR(whole.potential(x), part.potential(x), 1e-4);
  EXPECT_LT((whole.gradient(x) - part.gradient(x)).norm(), 1e-4);
}

TEST(PotentialField, ExposureDoesNotMatter) {
  const cv::Mat image = dark_band(30.0, 50.0);
  cv::Mat dim;
  image.convertTo(dim, CV_32F, 0.5);
  const cv::Rect all(0, 0, 120, 80);
  EXPECT_NEAR(PotentialField(image, all, {}).potential({60.0, 30.0}),
              PotentialField(dim, all, {}).potential({60.0, 30.0}),
              1e-3);
}

TEST(PotentialField, OutsideBlankAndTinyAreFlat) {
  const PotentialField blank(cv::Mat(40, 40, CV_8U, cv::Scalar(90)), cv::Rect(0, 0, 40, 40), {});
  EXPECT_EQ(blank.potential({20.0, 20.0}), 0.0);
  EXPECT_EQ(blank.gradient({20.0, 20.0}), Point2::Zero());
  const PotentialField tiny(cv::Mat(1, 1, CV_8U, cv::Scalar(9)), cv::Rect(0, 0, 1, 1), {});
  EXPECT_EQ(tiny.gradient({0.0, 0.0}), Point2::Zero());
  const PotentialField band(dark_band(30.0, 50.0), cv::Rect(0, 0, 120, 80), {});
  EXPECT_EQ(band.gradient({-5.0, 30.0}), Point2::Zero());
  EXPECT_EQ(band.gradient({std::nan(""), 30.0}), Point2::Zero());
}

}  // namespace
}  // namespace zygoma
