#include "tracker/snake.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "src/base/check.h"
#include "tracker/cyclic_band.h"

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

// A ravine along a circle about the origin.
class RingRavine : public ImageLandscape {
 public:
  explicit RingRavine(double radius) : radius_(radius) {}
  double potential(size_t, const Point2& x) const override {
    const double d = x.norm() - radius_;
    return -std::exp(-d * d / 8.0);
  }
  Point2 gradient(size_t node, const Point2& x) const override {
    return -potential(node, x) * (x.norm() - radius_) / 4.0 * x.normalized();
  }

 private:
  double radius_;
};

std::vector<Point2> circle(int n, double radius) {
  std::vector<Point2> nodes;
  for (int i = 0; i < n; ++i) {
    const double t = 2.0 * 3.14159265358979 * i / n;
    nodes.emplace_back(radius * std::cos(t), radius * std::sin(t));
  }
  return nodes;
}

class SnakeEndsTest : public testing::TestWithParam<SnakeEnds> {};
INSTANTIATE_TEST_SUITE_P(Ends,
                         SnakeEndsTest,
                         testing::Values(SnakeEnds::kFree, SnakeEnds::kFixed, SnakeEnds::kClosed));

TEST_P(SnakeEndsTest, InternalForceIsMinusTheGradientOfTheEnergy) {
  SnakeOptions options;
  options.ends = GetParam();
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

TEST_P(SnakeEndsTest, EnergyNeverRisesWhateverTheStep) {
  for (const double step : {0.1, 1.0, 10.0, 1e4}) {
    SnakeOptions options;
    options.ends = GetParam();
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
  for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
    SnakeOptions options;
    options.stepping = stepping;
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
}

TEST(Snake, NonFiniteForceStopsItWhereItWas) {
  const std::vector<Point2> nodes = random_chain(5, 9);
  Snake snake(nodes, {});
  const BrokenLandscape broken;
  EXPECT_EQ(snake.relax(&broken).stop, SnakeStop::kNotFinite);
  EXPECT_EQ(snake.nodes(), nodes);
}

// The step's matrix against the same system solved densely.
TEST(CyclicBand, SolvesWhatADenseMatrixSolves) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  for (const bool closed : {false, true}) {
    for (const size_t n : {3U, 5U, 6U, 7U, 31U}) {
      if (closed && n < 5) continue;
      std::vector<double> h0(n), h1(n), h2(n);
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(static_cast<int>(n), static_cast<int>(n));
      const auto couple = [&](size_t i, size_t j, double v) {
        a(static_cast<int>(i), static_cast<int>(j)) += v;
        if (i != j) a(static_cast<int>(j), static_cast<int>(i)) += v;
      };
      for (size_t i = 0; i < n; ++i) {
        h0[i] = 5.0 + value(random);
        h1[i] = closed || i + 1 < n ? value(random) : 0.0;
        h2[i] = closed || i + 2 < n ? value(random) : 0.0;
        couple(i, i, h0[i]);
        couple(i, (i + 1) % n, h1[i]);
        couple(i, (i + 2) % n, h2[i]);
      }
      Eigen::MatrixXd right(static_cast<int>(n), 2);
      std::vector<Point2> x(n);
      for (size_t i = 0; i < n; ++i) {
        x[i] = {value(random), value(random)};
        right.row(static_cast<int>(i)) = x[i];
      }
      CyclicBand band;
      band.factor(h0, h1, h2);
      band.solve(x);
      const Eigen::MatrixXd expected = a.partialPivLu().solve(right);
      for (size_t i = 0; i < n; ++i) {
        EXPECT_LT((x[i].transpose() - expected.row(static_cast<int>(i))).norm(), 1e-13) << n;
      }
    }
  }
}

TEST(Snake, FixedEndsStayToTheBit) {
  for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
    SnakeOptions options;
    options.ends = SnakeEnds::kFixed;
    options.stepping = stepping;
    const std::vector<Point2> nodes = random_chain(9, 12);
    Snake snake(nodes, options);
    const LineRavine ravine(12.0);
    for (int i = 0; i < 100; ++i) snake.advance(&ravine);
    EXPECT_EQ(snake.nodes().front(), nodes.front());
    EXPECT_EQ(snake.nodes().back(), nodes.back());
    EXPECT_GT((snake.nodes()[4] - nodes[4]).norm(), 0.01);
  }
}

TEST(Snake, ClosedChainSettlesOnARing) {
  SnakeOptions options;
  options.ends = SnakeEnds::kClosed;
  options.max_iterations = 2000;
  options.tolerance_px = 1e-6;
  options.tension = 0.01;
  options.rigidity = 0.01;
  for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
    options.stepping = stepping;
    Snake snake(circle(24, 21.0), options);
    const RingRavine ring(20.0);
    EXPECT_EQ(snake.relax(&ring).stop, SnakeStop::kConverged);
    // Every node is where its neighbours on the ring say, seam or not.
    const double radius = snake.nodes()[0].norm();
    EXPECT_NEAR(radius, 20.0, 0.1);
    for (const Point2& p : snake.nodes()) EXPECT_NEAR(p.norm(), radius, 1e-4);
  }
}

TEST(Snake, ExplicitAndImplicitSettleInTheSamePlaces) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    SnakeOptions options;
    options.max_iterations = 20000;
    options.tolerance_px = 1e-9;
    const LineRavine ravine(12.0);
    std::vector<Point2> settled[2];
    for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
      options.stepping = stepping;
      Snake snake(random_chain(11, seed), options);
      std::vector<SoftAnchor> anchors(11);
      anchors[3] = {Point2(16.0, 11.0), 0.2};
      anchors[7] = {Point2(33.0, 13.0), 0.2};
      snake.set_anchors(anchors);
      EXPECT_EQ(snake.relax(&ravine).stop, SnakeStop::kConverged);
      settled[stepping == SnakeStepping::kExplicit] = snake.nodes();
    }
    for (size_t i = 0; i < settled[0].size(); ++i) {
      EXPECT_LT((settled[0][i] - settled[1][i]).norm(), 1e-5) << "node " << i;
    }
  }
}

TEST(Snake, ExplicitStepIsSplitWhateverTheStiffness) {
  for (const double rigidity : {0.05, 1.0, 100.0}) {
    SnakeOptions options;
    options.stepping = SnakeStepping::kExplicit;
    options.rigidity = rigidity;
    Snake snake(random_chain(11, 8), options);
    const LineRavine ravine(12.0);
    double before = snake.internal_energy();
    for (int i = 0; i < 20; ++i) {
      snake.advance(nullptr);
      EXPECT_LE(snake.internal_energy(), before + 1e-12) << rigidity;
      before = snake.internal_energy();
    }
    for (int i = 0; i < 200; ++i) EXPECT_TRUE(std::isfinite(snake.advance(&ravine)));
    for (const Point2& p : snake.nodes()) EXPECT_LT(std::abs(p.y() - 12.0), 4.0);
  }
}

TEST(Snake, WholeExplicitStepBeyondTheBoundIsRefused) {
  SnakeOptions options;
  options.stepping = SnakeStepping::kExplicit;
  options.whole_step = true;
  options.tension = options.rigidity = 1.0;
  options.step = 0.099;
  EXPECT_NO_THROW(Snake(random_chain(5, 1), options));
  options.step = 0.101;
  try {
    Snake snake(random_chain(5, 1), options);
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("= 0.1"), std::string::npos) << error.what();
  }
}

TEST(Resample, KeepsEndsAndEvensTheSpacing) {
  const std::vector<Point2> line{{0, 0}, {1, 0}, {2, 0}, {10, 0}};
  const std::vector<Point2> even = resample(line, 6);
  ASSERT_EQ(even.size(), 6U);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(even[static_cast<size_t>(i)].x(), 2.0 * i, 1e-12);
}

}  // namespace
}  // namespace zygoma
