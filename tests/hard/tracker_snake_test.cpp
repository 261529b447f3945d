// Hard cases of one snake on drawn pictures: edges and bands whose place is known to a fraction of
// a pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <random>

#include "src/base/check.h"
#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/potential_field.h"
#include "tracker/snake.h"

namespace zygoma::hard {
namespace {

constexpr double kSigma = 1.6;  // of the tracker's fine potential
const cv::Rect kWhole(0, 0, 160, 120);
const Point2 kUp(0.0, -1.0);  // brightness falls downwards: the upper edge of a dark band

// A dark band between two heights (a bottom far below makes it a single edge), with grain that
// moves along with it if wanted.
cv::Mat band(double top, double bottom, double grain = 0.0) {
  cv::Mat image(kWhole.size(), CV_32F);
  for (int row = 0; row < image.rows; ++row) {
    const auto step = [row](double at) { return 0.5 * (1.0 + std::erf((row - at) / 1.4)); };
    image.row(row).setTo(cv::Scalar(190.0 - 110.0 * (step(top) - step(bottom))));
  }
  if (grain > 0.0) {
    cv::RNG random(3);
    cv::Mat noise(image.size(), CV_32F);
    random.fill(noise, cv::RNG::NORMAL, 0.0, grain);
    image += noise;
  }
  cv::Mat out;
  image.convertTo(out, CV_8U);
  return out;
}

class UpperEdge : public ImageLandscape {
 public:
  explicit UpperEdge(const cv::Mat& image) : field_(image, kWhole, {kSigma, 0.99, 1.0}) {}
  double potential(size_t, const Point2& x) const override { return field_.potential(x, kUp); }
  Point2 gradient(size_t, const Point2& x) const override { return field_.gradient(x, kUp); }

 private:
  PotentialField field_;
};

std::vector<Point2> level_line(double y, int n = 11, double spacing = 8.0) {
  std::vector<Point2> nodes;
  for (int i = 0; i < n; ++i) nodes.emplace_back(36.0 + spacing * i, y);
  return nodes;
}

double evidence_of(const ImageLandscape& image, const std::vector<Point2>& nodes) {
  double sum = 0.0;
  for (const Point2& p : nodes) sum -= image.potential(0, p) / static_cast<double>(nodes.size());
  return sum;
}

double largest_error(const std::vector<Point2>& nodes, double row) {
  double largest = 0.0;
  for (const Point2& p : nodes) largest = std::max(largest, std::abs(p.y() - row));
  return largest;
}

// Standard deviation of the spacing over its mean.
double spacing_variation(const std::vector<Point2>& nodes) {
  double sum = 0.0, sum2 = 0.0;
  const auto n = static_cast<double>(nodes.size() - 1);
  for (size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double d = (nodes[i + 1] - nodes[i]).norm();
    sum += d;
    sum2 += d * d;
  }
  return std::sqrt(std::max(0.0, sum2 / n - sum * sum / (n * n))) / (sum / n);
}

TEST(HC39, ASnakeOnAStillPictureStaysWhereItSettled) {
  for (const double grain : {0.0, 12.0}) {
    const UpperEdge image(band(50.3, 66.0, grain));
    SnakeOptions options;
    options.max_iterations = 2000;
    options.tolerance_px = 1e-6;
    Snake snake(level_line(51.0), options);
    snake.relax(&image);
    const std::vector<Point2> settled = snake.nodes();
    double drift = 0.0;
    for (int i = 0; i < 1000; ++i) snake.advance(&image);
    for (size_t i = 0; i < settled.size(); ++i) {
      drift = std::max(drift, (snake.nodes()[i] - settled[i]).norm());
    }
    EXPECT_LT(drift, 0.05);
    record(grain > 0.0 ? "one snake on an edge with grain of 12 grey levels, 1000 steps"
                       : "one snake on a clean edge, 1000 steps",
           "drifts by " + figure(drift) + " px",
           "< 0.05 px");
  }
}

// Every picture starts from where the last one ended: what a snake without prediction can follow.
TEST(HC40, ASnakeAloneFollowsAnEdgeWithinItsCaptureRange) {
  std::string measured;
  for (const double speed : {0.2, 1.0, 3.0, 8.0}) {
    Snake snake(level_line(40.0), {});
    double worst = 0.0;
    double evidence = 1.0;
    double row = 40.0;
    for (int frame = 0; frame < 8 && row + speed < 105.0; ++frame) {
      row += speed;
      const UpperEdge image(band(row, row + 300.0));
      snake.relax(&image);
      worst = std::max(worst, largest_error(snake.nodes(), row));
      evidence = evidence_of(image, snake.nodes());
    }
    measured += (measured.empty() ? "" : "; ") + figure(speed) + " px: error " + figure(worst) +
                ", evidence " + figure(evidence);
    const bool within = speed <= 2.0 * kSigma;
    if (within) {
      EXPECT_LT(worst, 0.2) << speed;
      EXPECT_GT(evidence, 0.5) << speed;
    } else {
      // Left behind, on nothing: what is under the snake says so.
      EXPECT_LT(evidence, 0.05) << speed;
    }
  }
  record("an edge moves by 0.2, 1, 3, 8 px per picture, a snake without prediction, sigma 1.6 px",
         measured,
         "followed up to 2 sigma = 3.2 px; beyond, no evidence under it");
}

TEST(HC42, NodesKeepTheirSpacing) {
  // The edge sways, and the picture has grain that nodes could gather on.
  std::vector<Point2> nodes = level_line(50.0);
  double alone = 0.0, shortest = 1.0;
  Snake free_running(nodes, {});
  double resampled = 0.0;
  for (int frame = 0; frame < 500; ++frame) {
    const double row = 50.0 + 6.0 * std::sin(0.1 * frame);
    const UpperEdge image(band(row, row + 16.0, 12.0));
    free_running.relax(&image);
    alone = std::max(alone, spacing_variation(free_running.nodes()));
    Snake snake(nodes, {});
    snake.relax(&image);
    nodes = resample(snake.nodes(), static_cast<int>(nodes.size()));
    resampled = std::max(resampled, spacing_variation(nodes));
    shortest = std::min(shortest, (nodes.back() - nodes.front()).norm() / 80.0);
  }
  EXPECT_LT(alone, 0.3);
  EXPECT_LT(resampled, 0.3);
  EXPECT_GT(shortest, 0.6);
  record(
      "500 pictures of a swaying edge with grain; one snake that runs on; one resampled in every "
      "picture, as the tracker does",
      "spacing varies by " + figure(alone) + "; " + figure(resampled) + "; at least " +
          figure(100.0 * shortest) + " % of its length is left",
      "< 0.3");
}

TEST(HC56, ABrowStaysOnTheEdgeItWasGiven) {
  std::string measured;
  for (const double thickness : {6.0, 3.0}) {
    Snake snake(level_line(50.0), {});
    double worst = 0.0;
    for (int frame = 0; frame < 500; ++frame) {
      const double row = 50.0 + 12.0 * std::sin(0.1 * frame) + 0.5 * std::sin(1.9 * frame);
      const UpperEdge image(band(row, row + thickness, 6.0));
      snake.relax(&image);
      worst = std::max(worst, largest_error(snake.nodes(), row));
    }
    EXPECT_LT(worst, 0.5 * thickness) << thickness;
    measured += (measured.empty() ? "" : "; ") + figure(thickness) + " px thick: " + figure(worst) +
                " px from the upper edge";
  }
  record("a dark band that sways by up to 2 px per picture, 500 pictures, no prediction",
         measured,
         "never nearer to the other edge");
}

TEST(HC58, ASnakeWithoutEvidenceKeepsItsLength) {
  const UpperEdge image(cv::Mat(kWhole.size(), CV_8U, cv::Scalar(120)));
  std::vector<Point2> nodes = level_line(50.0);
  for (size_t i = 0; i < nodes.size(); ++i) nodes[i].y() += 3.0 * std::sin(1.3 * double(i));
  SnakeOptions options;
  options.viscosity = 0.3;
  options.tension = 0.2;
  Snake snake(nodes, options);
  double start = 0.0, now = 0.0;
  for (const double l : snake.rest_lengths()) start += l;
  for (int frame = 0; frame < 100; ++frame) snake.relax(&image);
  for (size_t i = 0; i + 1 < nodes.size(); ++i) {
    now += (snake.nodes()[i + 1] - snake.nodes()[i]).norm();
    EXPECT_GE(snake.rest_lengths()[i],
              options.min_length * (nodes[i + 1] - nodes[i]).norm() - 1e-12);
  }
  EXPECT_GT(now, options.min_length * start);
  EXPECT_LT(now, options.max_length * start);
  EXPECT_EQ(evidence_of(image, snake.nodes()), 0.0);
  record("a crooked, stiff chain with viscous springs on a flat picture, 100 pictures",
         figure(now / start) + " of its length, evidence 0",
         "within the clamp of 0.6 to 1.6; low evidence");
}

TEST(HC59, NodesDoNotSlideAlongAStraightEdge) {
  Snake snake(level_line(50.0), {});
  std::vector<Point2> nodes = level_line(50.0);
  double alone = 0.0, resampled = 0.0;
  for (int frame = 0; frame < 200; ++frame) {
    const double row = 50.0 + 20.0 * std::sin(0.07 * frame);
    const UpperEdge image(band(row, row + 300.0));
    snake.relax(&image);
    Snake again(nodes, {});
    again.relax(&image);
    nodes = resample(again.nodes(), static_cast<int>(nodes.size()));
    const std::vector<Point2> start = level_line(50.0);
    for (size_t i = 0; i < nodes.size(); ++i) {
      alone = std::max(alone, std::abs(snake.nodes()[i].x() - start[i].x()));
      resampled = std::max(resampled, std::abs(nodes[i].x() - start[i].x()));
    }
  }
  EXPECT_LT(alone, 1.0);
  EXPECT_LT(resampled, 1.0);
  record(
      "a straight edge moves along its normal by up to 1.4 px per picture, 200 pictures; one "
      "snake that runs on; one resampled in every picture",
      "nodes slide by " + figure(alone) + "; " + figure(resampled) + " px",
      "< 1 px");
}

class BrokenLandscape : public ImageLandscape {
 public:
  explicit BrokenLandscape(double value) : value_(value) {}
  double potential(size_t, const Point2&) const override { return value_; }
  Point2 gradient(size_t node, const Point2&) const override {
    return node == 3 ? Point2::Constant(value_) : Point2::Zero();
  }

 private:
  double value_;
};

TEST(HC67, ASnakeKeepsItsNodesWhenAForceIsNotFinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {std::nan(""), kInfinity, -kInfinity}) {
    for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
      SnakeOptions options;
      options.stepping = stepping;
      Snake snake(level_line(50.0), options);
      const BrokenLandscape broken(value);
      EXPECT_EQ(snake.relax(&broken).stop, SnakeStop::kNotFinite);
      EXPECT_EQ(snake.nodes(), level_line(50.0));
    }
  }
  // A picture of floats that holds NaN and infinity.
  cv::Mat image;
  band(50.0, 66.0).convertTo(image, CV_32F);
  image.at<float>(50, 60) = std::numeric_limits<float>::quiet_NaN();
  image.at<float>(50, 100) = std::numeric_limits<float>::infinity();
  const UpperEdge field(image);
  Snake snake(level_line(50.5), {});
  snake.relax(&field);
  for (const Point2& p : snake.nodes()) EXPECT_TRUE(p.allFinite());
  record("NaN or infinity in the force at one node, or in the picture, both ways of stepping",
         "the snake keeps its last nodes and reports \"not finite\"",
         "reported where it appears; finite output",
         Outcome::kRefused);
}

// What is left of the stiffest motion, alternating nodes of a closed chain, after Euler's steps by
// hand with the snake's own force. A chain of length zero has linear springs.
double growth_of_alternating(double a, double b, double dt, int steps) {
  SnakeOptions options;
  options.ends = SnakeEnds::kClosed;
  options.tension = a;
  options.rigidity = b;
  Snake snake(std::vector<Point2>(12, Point2::Zero()), options);
  std::vector<Point2> nodes;
  for (int i = 0; i < 12; ++i) nodes.emplace_back(i % 2 == 0 ? 1.0 : -1.0, 0.0);
  for (int k = 0; k < steps; ++k) {
    snake.set_nodes(nodes);
    const std::vector<Point2> force = snake.internal_force();
    for (size_t i = 0; i < nodes.size(); ++i) nodes[i] += dt / options.damping * force[i];
  }
  return nodes[0].norm();
}

TEST(HC68, TheExplicitStepHasTheBoundTheFormulaSays) {
  const std::array<std::pair<double, double>, 11> pairs{{{1.0, 0.0},
                                                         {0.0, 1.0},
                                                         {1.0, 1.0},
                                                         {0.0, 10.0},
                                                         {0.02, 0.05},
                                                         {0.02, 0.3},
                                                         {10.0, 0.1},
                                                         {3.0, 0.5},
                                                         {0.1, 3.0},
                                                         {100.0, 1.0},
                                                         {0.5, 40.0}}};
  double furthest = 0.0;
  for (const auto& [a, b] : pairs) {
    SnakeOptions options;
    options.tension = a;
    options.rigidity = b;
    const double bound = explicit_step_bound(options);
    // Where an alternating chain neither grows nor dies out.
    double stable = 0.5 * bound, unstable = 2.0 * bound;
    while (unstable - stable > 1e-6 * bound) {
      const double middle = 0.5 * (stable + unstable);
      (growth_of_alternating(a, b, middle, 400) > 1.0 ? unstable : stable) = middle;
    }
    furthest = std::max(furthest, std::abs(stable / bound - 1.0));
    EXPECT_NEAR(stable / bound, 1.0, 1e-3) << a << ", " << b;
    options.stepping = SnakeStepping::kExplicit;
    options.whole_step = true;
    options.step = 0.999 * bound;
    EXPECT_NO_THROW(Snake(level_line(50.0), options));
    options.step = 1.001 * bound;
    EXPECT_THROW(Snake(level_line(50.0), options), InputError);
  }
  record("explicit step, eleven pairs (a, b) from (1, 0) to (0.5, 40)",
         "becomes unstable at the bound to " + figure(furthest) +
             "; 1.001 of it is refused with the bound stated",
         "bound met to 0.1 %; refusal states it");
}

TEST(HC68, SubStepsAndTheImplicitStepAreStableForAnyStep) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> jitter(-3.0, 3.0);
  std::vector<Point2> nodes = level_line(50.0);
  for (Point2& p : nodes) p += Point2(jitter(random), jitter(random));
  const UpperEdge image(band(50.3, 66.0));
  for (const SnakeStepping stepping : {SnakeStepping::kImplicit, SnakeStepping::kExplicit}) {
    for (const double step : {0.1, 1.0, 10.0, stepping == SnakeStepping::kImplicit ? 1e6 : 100.0}) {
      SnakeOptions options;
      options.stepping = stepping;
      options.step = step;
      options.tension = 1.0;
      options.rigidity = 2.0;
      Snake snake(level_line(50.0), options);
      snake.set_nodes(nodes);
      double before = snake.internal_energy();
      for (int i = 0; i < 100; ++i) {
        snake.advance(nullptr);
        EXPECT_LE(snake.internal_energy(), before + 1e-9) << step;
        before = snake.internal_energy();
      }
      for (int i = 0; i < 20; ++i) EXPECT_TRUE(std::isfinite(snake.advance(&image)));
      EXPECT_LT(largest_error(snake.nodes(), 50.3), 10.0);
    }
  }
  record(
      "a chain with a = 1, b = 2 (bound 0.056) stepped by 0.1 to 100 in explicit sub-steps, by "
      "0.1 to 10^6 implicitly",
      "the energy never rises",
      "automatic sub-steps; the semi-implicit step is stable for any dt");
}

}  // namespace
}  // namespace zygoma::hard
