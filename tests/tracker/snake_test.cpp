#include "tracker/snake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace zygoma {
namespace {

std::vector<Point2> random_chain(int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-2.0, 2.0);
  std::vector<Point2> nodes;
  for (int i = 0; i < n; ++i) nodes.emplace_back(5.0 * i + jitter(random), 10.0 + jitter(random));
  return nodes;
}

// A ravine along the line y = height: P = -exp(-(y - height)^2 / 2 s^2).
class LineRavine : public ImageLandscape {
 public:
  explicit LineRavine(double height) : height_(height) {}
  double potential(size_t, const Point2& x) const override {
    const double d = x.y() - height_;
    return -std::exp(-d * d / 8.0);
  }
  Point2 gradient(size_t node, const Point2& x) const override {
    return {0.0, -potential(node, x) * (x.y() - height_) / 4.0};
  }

 private:
  double height_;
};

class BrokenLandscape : public ImageLandscape {
 public:
  double potential(size_t, const Point2&) const override { return 0.0; }
  Point2 gradient(size_t, const Point2&) const override {
    return Point2::Constant(std::numeric_limits<double>::quiet_NaN());
  }
};

TEST(Snake, InternalForceIsMinusTheGradientOfTheEnergy) {
  SnakeOptions options;
  options.tension = 0.7;
  options.rigidity = 0.3;
  options.viscosity = 0.1;  // gives the springs rest lengths that differ from their lengths
  options.step = 1.0;
  Snake moved(random_chain(9, 1), options);
  LineRavine ravine(14.0);
  for (int i = 0; i < 5; ++i) moved.advance(&ravine);
  const std::vector<Point2> force = moved.internal_force();
  const double h = 1e-5;
  for (size_t i = 0; i < moved.nodes().size(); ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const auto energy = [&](double by) {
        Snake copy = moved;
        std::vector<Point2> nodes = moved.nodes();
        nodes[i][axis] += by;
        copy.set_nodes(nodes);
        return copy.internal_energy();
      };
      EXPECT_NEAR(force[i][axis], -(energy(h) - energy(-h)) / (2.0 * h), 1e-7);
    }
  }
}

TEST(Snake, StraightChainAtRestStaysPut) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 11; ++i) nodes.emplace_back(3.0 + 4.0 * i, 7.0 - 2.0 * i);
  Snake snake(nodes, {});
  for (int i = 0; i < 100; ++i) snake.advance(nullptr);
  for (size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_LT((snake.nodes()[i] - nodes[i]).norm(), 1e-10);
  }
}

TEST(Snake, EnergyNeverRisesWhateverTheStep) {
  for (const double step : {0.1, 1.0, 10.0, 1e4}) {
    SnakeOptions options;
    options.tension = 1.0;
    options.rigidity = 0.5;
    options.step = step;
    Snake snake(random_chain(9, 3), options);
    // Rest lengths of a calm chain, nodes of a disturbed one.
    snake.set_nodes(random_chain(9, 4));
    double before = snake.internal_energy();
    const double start = before;
    for (int i = 0; i < 200; ++i) {
      snake.advance(nullptr);
      const double now = snake.internal_energy();
      EXPECT_LE(now, before + 1e-12) << "step " << step << ", iteration " << i;
      before = now;
    }
    EXPECT_LT(before, 0.9 * start);
  }
}

TEST(Snake, StretchedSpringPullsItsEndsTogether) {
  SnakeOptions options;
  options.rigidity = 0.0;
  options.tension = 1.0;
  Snake snake({{0, 0}, {1, 0}, {2, 0}}, options);
  snake.set_nodes({{0, 0}, {2, 0}, {4, 0}});
  const std::vector<Point2> force = snake.internal_force();
  EXPECT_GT(force.front().x(), 0.0);
  EXPECT_LT(force.back().x(), 0.0);
  EXPECT_NEAR(force[1].norm(), 0.0, 1e-12);
}

TEST(Snake, SettlesInARavine) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) nodes.emplace_back(5.0 * i, 12.0);
  SnakeOptions options;
  options.max_iterations = 300;
  options.tolerance_px = 1e-4;
  Snake snake(nodes, options);
  const LineRavine ravine(14.3);
  const SnakeReport report = snake.relax(&ravine);
  EXPECT_EQ(report.stop, SnakeStop::kConverged) << to_string(report.stop);
  for (const Point2& p : snake.nodes()) EXPECT_NEAR(p.y(), 14.3, 0.01);
}

TEST(Snake, AnchorsHoldHoweverStrong) {
  std::vector<Point2> nodes;
  for (int i = 0; i < 9; ++i) nodes.emplace_back(5.0 * i, 12.0);
  Snake snake(nodes, {});
  std::vector<SoftAnchor> anchors(9);
  anchors[0] = {Point2(-3.0, 9.0), 1e9};
  snake.set_anchors(anchors);
  snake.relax(nullptr);
  EXPECT_LT((snake.nodes()[0] - Point2(-3.0, 9.0)).norm(), 1e-6);
}

TEST(Snake, SpringsForgetTheirLengthOnlyWithinTheClamp) {
  SnakeOptions options;
  options.viscosity = 0.5;
  options.step = 1.0;
  options.tension = 0.1;
  options.rigidity = 0.0;
  std::vector<Point2> nodes;
  for (int i = 0; i < 5; ++i) nodes.emplace_back(10.0 * i, 0.0);
  Snake snake(nodes, options);
  std::vector<SoftAnchor> anchors(5);
  anchors[0] = {Point2(0, 0), 10.0};
  anchors[4] = {Point2(200, 0), 10.0};
  snake.set_anchors(anchors);
  for (int i = 0; i < 500; ++i) snake.advance(nullptr);
  for (const double l : snake.rest_lengths()) {
    EXPECT_LE(l, options.max_length * 10.0 + 1e-12);
    EXPECT_GT(l, 15.0);
  }
}

TEST(Snake, NonFiniteForceStopsItWhereItWas) {
  const std::vector<Point2> nodes = random_chain(5, 9);
  Snake snake(nodes, {});
  const BrokenLandscape broken;
  EXPECT_EQ(snake.relax(&broken).stop, SnakeStop::kNotFinite);
  EXPECT_EQ(snake.nodes(), nodes);
}

TEST(Resample, KeepsEndsAndEvensTheSpacing) {
  const std::vector<Point2> line{{0, 0}, {1, 0}, {2, 0}, {10, 0}};
  const std::vector<Point2> even = resample(line, 6);
  ASSERT_EQ(even.size(), 6U);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(even[static_cast<size_t>(i)].x(), 2.0 * i, 1e-12);
}

}  // namespace
}  // namespace zygoma
