// A tensile test against closed forms: springs in series and in parallel, the biphasic curve, and
// the standard linear solid.
#include "face/strip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "src/base/check.h"

namespace zygoma {
namespace {

// Work lost over the last `num_points` steps, per volume (kPa).
double loop_area(const std::vector<StripPoint>& points, int num_points) {
  double area = 0.0;
  for (std::size_t k = points.size() - num_points; k < points.size(); ++k) {
    area += 0.5 * (points[k].stress_kpa + points[k - 1].stress_kpa) *
            (points[k].strain - points[k - 1].strain);
  }
  return area;
}

constexpr double kRatio = 0.5;
constexpr double kRelaxation_s = 0.3;

const std::vector<EffectChoice> kViscosity{
    {"viscosity", {{"ratio", kRatio}, {"relaxation_s", kRelaxation_s}}}};

StripOptions coarse() {
  StripOptions options;
  options.cells_along = 6;
  options.cells_across = 2;
  return options;
}

// `series` links one after the other between two clamps, each of `parallel` equal springs.
Strip chain(int series, int parallel, double stiffness_mn_per_mm) {
  Strip strip;
  Lattice& lattice = strip.lattice;
  strip.length_mm = 10.0 * series;
  strip.area_mm2 = 1.0;
  lattice.num_vertices = lattice.num_free_nodes = series - 1;
  // Free nodes first, then the clamps.
  const auto node = [&](int place) {
    return place == 0 ? series - 1 : place == series ? series : place - 1;
  };
  lattice.rest_mm.resize(series + 1);
  for (int k = 0; k <= series; ++k) lattice.rest_mm[node(k)] = {10.0 * k, 0.0, 0.0};
  lattice.mass_kg.assign(series + 1, 1e-6);
  for (int k = 0; k < series; ++k) {
    for (int p = 0; p < parallel; ++p) {
      lattice.springs.push_back({node(k), node(k + 1), 0.0, 10.0, {.alpha = stiffness_mn_per_mm}});
    }
  }
  for (int k = 0; k + 1 < series; ++k) {
    Column column;
    column.vertex = {k, k, k};
    column.nodes = {k};
    column.on_bone = false;
    lattice.columns.push_back(column);
    lattice.neighbors.push_back({k == 0 ? 1 : k - 1});
  }
  lattice.column_of.assign(series + 1, 0);
  for (int k = 0; k + 1 < series; ++k) lattice.column_of[k] = k;
  strip.anatomy.surface.positions_mm.assign(lattice.rest_mm.begin(),
                                            lattice.rest_mm.begin() + series - 1);
  strip.anatomy.tissue_depth_mm.assign(series - 1, 1.0);
  strip.anatomy.mandible_weight.assign(series - 1, 0.0);
  strip.anatomy.region.assign(series - 1, Region::kFace);
  strip.pulled = {node(series)};
  return strip;
}

TEST(TensileTest, SpringsInSeriesAndInParallel) {
  constexpr double kStiffness = 2.5;  // mN/mm
  for (const int series : {3, 8}) {
    for (const int parallel : {1, 4}) {
      SCOPED_TRACE(std::to_string(series) + " x " + std::to_string(parallel));
      TensileTest test(chain(series, parallel, kStiffness), {});
      const double strain = 0.07;
      const StripPoint point = test.hold(strain);
      EXPECT_TRUE(point.converged);
      const double elongation_mm = strain * 10.0 * series;
      EXPECT_NEAR(point.stress_kpa, kStiffness * parallel / series * elongation_mm, 1e-9);
    }
  }
  // Under the same load four times the stiffness is a quarter of the strain.
  TensileTest soft(chain(5, 1, kStiffness), {});
  TensileTest stiff(chain(5, 1, 4.0 * kStiffness), {});
  soft.hold(0.01);
  stiff.hold(0.01);
  const StripPoint soft_point = soft.load(2.0);
  const StripPoint stiff_point = stiff.load(2.0);
  EXPECT_TRUE(soft_point.converged);
  EXPECT_TRUE(stiff_point.converged);
  EXPECT_NEAR(soft_point.strain, 2.0 / kStiffness / 10.0, 1e-10);
  EXPECT_NEAR(stiff_point.strain, 0.25 * soft_point.strain, 1e-10);
}

TEST(TensileTest, StiffnessIsThatOfTheTissue) {
  StripOptions options = coarse();
  TensileTest test(make_strip(options), {});
  const double modulus = test.modulus_kpa();
  // Cells of other proportions resist somewhat differently: 12 % for half the size in the plane.
  options.cells_along *= 2;
  options.cells_across *= 2;
  TensileTest finer(make_strip(options), {});
  EXPECT_NEAR(finer.modulus_kpa() / modulus, 1.0, 0.15);
  // Four times the moduli, four times the stress.
  options = coarse();
  for (TissueLayer& layer : options.tissue.layers) layer.modulus_kpa *= 4.0;
  options.tissue.epidermis_modulus_kpa *= 4.0;
  TensileTest stiffer(make_strip(options), {});
  EXPECT_NEAR(stiffer.modulus_kpa() / modulus, 4.0, 1e-6);
  EXPECT_NEAR(stiffer.hold(0.1).stress_kpa / test.hold(0.1).stress_kpa, 4.0, 1e-6);
}

TEST(TensileTest, SlowStretchIsMonotoneContinuousAndBiphasic) {
  TensileTest test(make_strip(coarse()), {{"volume", {}}});
  constexpr int kSteps = 80;
  const std::vector<StripPoint> points = stretch_slowly(test, 0.4, kSteps);
  const double step = 0.4 / kSteps;
  std::vector<double> slope;
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_TRUE(points[k].converged) << "strain " << points[k].strain;
    if (k > 0) slope.push_back((points[k].stress_kpa - points[k - 1].stress_kpa) / step);
  }
  EXPECT_NEAR(points.front().stress_kpa, 0.0, 1e-9);
  const double soft = slope.front();
  const double stiff = slope.back();
  EXPECT_GT(stiff, 1.8 * soft) << "not biphasic";
  for (std::size_t k = 0; k < slope.size(); ++k) {
    EXPECT_GT(slope[k], 0.0) << "falls at " << points[k].strain;
    // No jump: half the step would see half the rise.
    EXPECT_LT(slope[k], 1.5 * stiff) << "jumps at " << points[k].strain;
    if (k == 0) continue;
    EXPECT_LT(std::abs(slope[k] - slope[k - 1]), 0.35 * stiff) << points[k].strain;
  }
  // Back by the same way: nothing is lost where nothing is slow.
  for (int k = kSteps; k >= 0; k -= 20) {
    EXPECT_NEAR(test.hold(points[k].strain).stress_kpa, points[k].stress_kpa, 1e-7);
  }
}

class SlowTissue : public testing::Test {
 protected:
  SlowTissue() : test_(make_strip(coarse()), kViscosity) {
    solid_ = {test_.modulus_kpa(), kRatio, kRelaxation_s};
  }
  static constexpr double kStrain = 1e-4;  // small against the bands of the springs' law

  TensileTest test_;
  StandardLinearSolid solid_;
};

TEST_F(SlowTissue, StressRelaxesAtHeldStrain) {
  // Steps of whatever length: at held strain they are exact.
  for (const double step_s : {0.01, 0.25}) {
    const std::vector<StripPoint> points = relax(test_, kStrain, 2.0, step_s);
    EXPECT_NEAR(points.front().stress_kpa / (solid_.modulus_kpa * kStrain), 1.0 + kRatio, 1e-3);
    EXPECT_NEAR(points.back().stress_kpa / (solid_.modulus_kpa * kStrain), 1.0, 2e-3);
    for (const StripPoint& point : points) {
      EXPECT_TRUE(point.converged);
      const double expected = solid_.relaxing_stress(kStrain, point.time_s);
      EXPECT_NEAR(point.stress_kpa / expected, 1.0, 3e-4) << point.time_s;
    }
  }
}

TEST_F(SlowTissue, StrainCreepsUnderHeldLoad) {
  const double stress = solid_.modulus_kpa * kStrain;
  const auto worst = [&](double step_s) {
    double largest = 0.0;
    for (const StripPoint& point : creep(test_, stress, 2.0, step_s)) {
      EXPECT_TRUE(point.converged) << point.time_s;
      EXPECT_NEAR(point.stress_kpa / stress, 1.0, 1e-8);
      const double expected = solid_.creeping_strain(stress, point.time_s);
      largest = std::max(largest, std::abs(point.strain - expected) / kStrain);
    }
    return largest;
  };
  const double coarse_error = worst(0.1);
  const double fine_error = worst(0.05);
  EXPECT_LT(coarse_error, 2.5e-3);
  // Second order in the step, down to what the strain itself adds.
  EXPECT_LT(fine_error, 0.3 * coarse_error + 2e-4);
}

TEST_F(SlowTissue, CyclesLoseTheWorkTheyShould) {
  constexpr int kCycles = 6;
  constexpr int kSteps = 60;
  std::vector<double> areas;
  for (const double rate : {0.1, 1.0, 10.0}) {  // w tau
    const double period_s = 2.0 * std::numbers::pi * kRelaxation_s / rate;
    const std::vector<StripPoint> points = cycle(test_, kStrain, period_s, kCycles, kSteps);
    std::vector<StripPoint> exact = points;
    double largest = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_TRUE(points[k].converged);
      exact[k].stress_kpa = solid_.cycling_stress(kStrain, period_s, points[k].time_s);
      largest = std::max(largest, std::abs(points[k].stress_kpa - exact[k].stress_kpa));
    }
    // The sine as a polygon: (2 pi / kSteps)^2 / 12 of the slow branch, and the strain itself.
    EXPECT_LT(largest / (2.0 * solid_.modulus_kpa * kStrain), 1e-3) << rate;
    const double area = loop_area(points, kSteps);
    EXPECT_NEAR(area / loop_area(exact, kSteps), 1.0, 0.01) << rate;
    const double steady = std::numbers::pi * solid_.modulus_kpa * kRatio * kStrain * kStrain *
                          rate / (1.0 + rate * rate);
    // The fastest cycles have not forgotten the beginning yet.
    EXPECT_NEAR(area / steady, 1.0, rate > 1.0 ? 0.1 : 0.01) << rate;
    areas.push_back(area);
  }
  EXPECT_GT(areas[1], 2.0 * areas[0]);
  EXPECT_GT(areas[1], 2.0 * areas[2]);
}

TEST(TensileTest, RefusesStripsThatAreNone) {
  for (const auto& spoil : std::vector<void (*)(StripOptions&)>{
           [](StripOptions& o) { o.length_mm = 0.0; },
           [](StripOptions& o) { o.depth_mm = NAN; },
           [](StripOptions& o) { o.cells_along = 1; },
           [](StripOptions& o) { o.tissue.layers[1].modulus_kpa = -1.0; }}) {
    StripOptions options;
    spoil(options);
    EXPECT_THROW(make_strip(options), InputError);
  }
}

}  // namespace
}  // namespace zygoma
