// How the face follows its controls: HC-35 to HC-37.
#include <gtest/gtest.h>

#include <array>

#include "face/solvers/equilibrium.h"
#include "tests/hard/floating_point_traps.h"
#include "tests/hard/record.h"
#include "tests/hard/scenes.h"

namespace zygoma::hard {
namespace {

using HC35 = Trapped;
using HC36 = Trapped;
using HC37 = Trapped;

// Steps of the differences. Where the stiffness of many springs is about to change the longer one
// sees the change; at the shorter one the residuals of the two equilibria count more.
constexpr std::array<double, 2> kSteps{3e-4, 1e-4};

SettleOptions tight() {
  SettleOptions options;
  options.relative_residual = 1e-11;
  options.max_iterations = 200;
  return options;
}

// A direction in the space of the controls: one value per muscle, the last for the jaw.
Controls shifted(Controls controls, const Eigen::VectorXd& direction, double step) {
  const Eigen::Index jaw = direction.size() - 1;
  for (Eigen::Index m = 0; m < jaw; ++m) controls.contraction[m] += step * direction[m];
  controls.jaw_rad += step * direction[jaw];
  return controls;
}

// Relative error of the sensitivity along a direction, against the better of the differences; huge
// if an equilibrium was not found.
double error_along(Simulator& simulator,
                   const Controls& controls,
                   const FaceState& state,
                   const Eigen::MatrixXd& sensitivity,
                   const Eigen::VectorXd& direction) {
  double smallest = 1e30;
  for (const double step : kSteps) {
    std::array<FaceState, 2> moved{state, state};
    bool settled = true;
    for (const int side : {0, 1}) {
      const Controls at = shifted(controls, direction, side == 0 ? step : -step);
      settled = simulator.settle(at, moved[side]).converged && settled;
    }
    Eigen::VectorXd difference(sensitivity.rows());
    for (Eigen::Index k = 0; k < difference.size(); ++k) {
      difference[k] = (moved[0].positions_mm[k / 3][k % 3] - moved[1].positions_mm[k / 3][k % 3]) /
                      (2.0 * step);
    }
    if (!settled) continue;
    smallest =
        std::min(smallest, (difference - sensitivity * direction).norm() / difference.norm());
    if (smallest < 1e-5) break;
  }
  return smallest;
}

int springs_in_a_band(const Lattice& lattice, const std::vector<Vec3>& x) {
  int count = 0;
  for (const Spring& spring : lattice.springs) {
    const double l = std::sqrt((x[spring.j] - x[spring.i]).squaredNorm() + spring.softening_mm2);
    count += std::abs(l - spring.rest_mm - spring.law.critical_mm) < spring.law.band_mm;
  }
  return count;
}

struct ErrorsOfExpressions {
  int checked = 0;
  int unsettled = 0;
  int damped = 0;
  int in_band = 0;  // springs of all states together
  std::vector<double> errors;

  double worst() const { return *std::max_element(errors.begin(), errors.end()); }
  double median() {
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() / 2];
  }
};

// Random expressions; of each a random direction and some single controls.
ErrorsOfExpressions check_expressions(Simulator& simulator, int how_many, int single_controls) {
  const Anatomy& anatomy = simulator.anatomy();
  const int num_controls = static_cast<int>(anatomy.muscles.size()) + 1;
  ErrorsOfExpressions result;
  for (int seed = 1; seed <= how_many; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<unsigned>(seed));
    Controls controls = random_controls(anatomy, 0.6, random);
    for (double& c : controls.contraction) c = std::max(c, 2.0 * kSteps[0]);
    controls.jaw_rad += 2.0 * kSteps[0];
    FaceState state = simulator.rest();
    if (!simulator.settle(controls, state).converged) {
      ++result.unsettled;
      continue;
    }
    const Sensitivity sensitivity = simulator.surface_sensitivity(controls, state);
    result.damped += sensitivity.damped;
    result.in_band += springs_in_a_band(simulator.lattice(), state.positions_mm);
    ++result.checked;
    Eigen::VectorXd direction(num_controls);
    for (double& d : direction) d = random.next();
    std::vector<Eigen::VectorXd> directions{direction.normalized()};
    for (int k = 0; k < single_controls; ++k) {
      const int control = k == 0 ? num_controls - 1 : (7 * seed + 5 * k) % num_controls;
      directions.push_back(Eigen::VectorXd::Unit(num_controls, control));
    }
    for (const Eigen::VectorXd& d : directions) {
      const double error = error_along(simulator, controls, state, sensitivity.mm, d);
      EXPECT_LT(error, 1e-4);
      result.errors.push_back(error);
    }
  }
  return result;
}

void record_expressions(const std::string& scene, ErrorsOfExpressions& result) {
  record(scene,
         "worst " + figure(result.worst()) + ", median " + figure(result.median()) + " of " +
             std::to_string(result.errors.size()) + " directions; " +
             std::to_string(result.in_band) + " springs stood in the band around e_c; " +
             std::to_string(result.unsettled) + " expressions not settled, " +
             std::to_string(result.damped) + " damped",
         "< 1e-4 relative");
}

TEST_F(HC35, SensitivitiesOfRandomExpressionsMatchCentralDifferences) {
  const std::vector<Tissue> tissues = topologies();
  for (const Tissue& tissue : tissues) {
    SCOPED_TRACE(tissue.name);
    const bool is_default = &tissue == &tissues.front();
    Simulator simulator(shared(make_face_patch(small_patch())), tissue.model, tight());
    ErrorsOfExpressions result = check_expressions(simulator, repetitions(is_default ? 50 : 15), 2);
    EXPECT_EQ(result.unsettled, 0);
    record_expressions(std::to_string(result.checked) +
                           " random expressions up to 0.6, jaw to 0.2 "
                           "rad, patch, " +
                           tissue.name,
                       result);
  }
}

TEST_F(HC35, SensitivitiesOfTheHeadMatchCentralDifferences) {
  if (!long_tests()) GTEST_SKIP() << "ZYGOMA_LONG_TESTS is not set";
  Simulator simulator(generic_head(500), {}, tight());
  ErrorsOfExpressions result = check_expressions(simulator, 20, 5);
  record_expressions("20 random expressions up to 0.6, jaw to 0.2 rad, default head", result);
}

// A flat strip of stiff skin over soft tissue, springs of the printed law with one stiffness (they
// carry as much in compression as in tension), and a muscle at each end that pushes it together.
Anatomy strip() {
  constexpr int kLong = 24;
  constexpr int kWide = 3;
  constexpr double kCellMm = 4.0;
  Anatomy anatomy;
  for (int j = 0; j <= kWide; ++j) {
    for (int i = 0; i <= kLong; ++i) {
      anatomy.surface.positions_mm.emplace_back(
          kCellMm * (i - 0.5 * kLong), kCellMm * (j - 0.5 * kWide), 0.0);
    }
  }
  for (int j = 0; j < kWide; ++j) {
    for (int i = 0; i < kLong; ++i) {
      const int a = j * (kLong + 1) + i;
      const int d = a + kLong + 1;
      anatomy.surface.triangles.push_back({a, a + 1, d + 1});
      anatomy.surface.triangles.push_back({a, d + 1, d});
    }
  }
  const std::size_t n = anatomy.surface.positions_mm.size();
  anatomy.tissue_depth_mm.assign(n, 6.0);
  anatomy.mandible_weight.assign(n, 0.0);
  anatomy.region.assign(n, Region::kFace);
  for (const double side : {1.0, -1.0}) {
    anatomy.muscles.push_back(
        {side > 0.0 ? "end_L" : "end_R", Vec3(40.0 * side, 0.0, 0.0), Vec3::Zero(), 20.0, 0.4});
  }
  return anatomy;
}

TissueModel skin_that_buckles() {
  TissueModel model;
  model.lattice.law = SpringLaw::kLiteral;
  model.lattice.epidermis_modulus_kpa = 5000.0;
  model.lattice.epidermis_stiff_ratio = 1.0;
  model.lattice.layers = {{"fat", 0.7, 1.0, 1.0, 2.0, 1.0}, {"muscle", 1.0, 1.0, 1.0, 2.0, 1.0}};
  return model;
}

TEST_F(HC36, BucklingOfACompressedStripIsFlagged) {
  const auto anatomy = shared(strip());
  Simulator simulator(anatomy, skin_that_buckles(), tight());
  const FaceState rest = simulator.rest();
  const Sensitivity at_rest_now = simulator.surface_sensitivity({{0.0, 0.0}, 0.0}, rest);
  EXPECT_FALSE(at_rest_now.damped);
  // Straight on along the response at rest: what the strip would do if it did not buckle.
  const FaceEnergy energy(*anatomy, skin_that_buckles());
  EquilibriumSolver solver(energy);
  Factor factor(solver.hessian().free());
  solver.factor_at(rest.positions_mm, factor);
  Eigen::MatrixXd motion = energy.control_forces(rest.positions_mm, solver.hessian());
  factor.solve(motion);
  const auto straight = [&](double c) {
    FaceState state = rest;
    for (int k = 0; k < energy.lattice().num_free_nodes; ++k) {
      state.positions_mm[k] += c * (motion.block<3, 1>(3 * k, 0) + motion.block<3, 1>(3 * k, 1));
    }
    return state;
  };
  double critical = 0.0;
  for (double c = 0.005; c < 1.0 && critical == 0.0; c += 0.005) {
    if (simulator.surface_sensitivity({{c, c}, 0.0}, straight(c)).damped) critical = c;
  }
  EXPECT_GT(critical, 0.0);
  const double beyond = std::min(1.0, 3.0 * critical);
  const Sensitivity damped =
      simulator.surface_sensitivity({{beyond, beyond}, 0.0}, straight(beyond));
  EXPECT_TRUE(damped.damped);
  EXPECT_TRUE(damped.mm.allFinite());
  // The strip itself goes out of the plane and is at a strict minimum again.
  FaceState state = rest;
  const Controls controls{{beyond, beyond}, 0.0};
  EXPECT_TRUE(simulator.settle(controls, state).converged);
  double wave_mm = 0.0;
  for (int v = 0; v < simulator.lattice().num_vertices; ++v) {
    wave_mm = std::max(wave_mm,
                       std::abs(state.positions_mm[v].z() - straight(beyond).positions_mm[v].z()));
  }
  const Sensitivity buckled = simulator.surface_sensitivity(controls, state);
  EXPECT_FALSE(buckled.damped);
  const double error =
      error_along(simulator, controls, state, buckled.mm, Eigen::Vector3d(0.6, 0.8, 0.0));
  EXPECT_LT(error, 1e-4);
  record("flat strip of stiff skin pushed together from both ends",
         "Hessian of the straight strip not positive definite from contraction " +
             figure(critical) + " on: derivative finite and flagged as damped. Settled at " +
             figure(beyond) + " it stands in waves of " + figure(wave_mm) +
             " mm, a strict minimum, derivative right to " + figure(error),
         "Hessian reported as not positive definite; derivative flagged");
}

TEST_F(HC37, BackAtRestAfterAnExpression) {
  const auto head = generic_head(500);
  const auto patch = shared(make_face_patch());
  for (const Tissue& tissue : topologies()) {
    for (const auto& anatomy : {head, patch}) {
      if (kSanitized && anatomy == head) continue;
      Simulator simulator(anatomy, tissue.model);
      FaceState state = simulator.rest();
      Controls controls = at_rest(*anatomy);
      std::fill(controls.contraction.begin(), controls.contraction.end(), 0.6);
      controls.jaw_rad = 0.15;
      const SettleReport there = simulator.settle(controls, state);
      const SettleReport back = simulator.settle(at_rest(*anatomy), state);
      EXPECT_TRUE(back.converged) << tissue.name;
      const double off = largest_distance(state.positions_mm, simulator.rest().positions_mm);
      EXPECT_LT(off, 1e-6) << tissue.name;
      record("all muscles 0, 0.6, 0 and jaw 0, 0.15, 0 rad, " +
                 std::string(anatomy == head ? "default head, " : "patch, ") + tissue.name,
             "back to " + figure(off) + " mm" + (there.converged ? "" : " (0.6 did not converge)"),
             "< 1e-6 mm");
    }
  }
}

TEST_F(HC37, TwoPathsToTheSameExpression) {
  const auto head = generic_head(300);
  SettleOptions options = tight();
  options.relative_residual = 1e-9;
  Simulator simulator(head, {}, options);
  for (const Expression& expression : basic_expressions()) {
    if (!long_tests() && expression.name != "fear" && expression.name != "disgust") continue;
    const Controls goal = controls_of(expression.pose, *head);
    FaceState direct = simulator.rest();
    EXPECT_TRUE(simulator.settle(goal, direct).converged) << expression.name;
    // One muscle after the other, after all of another expression.
    FaceState roundabout = simulator.rest();
    Controls at = smile(*head, 0.8);
    simulator.settle(at, roundabout);
    for (std::size_t m = 0; m < at.contraction.size(); ++m) {
      at.contraction[m] = goal.contraction[m];
      simulator.settle(at, roundabout);
    }
    EXPECT_TRUE(simulator.settle(goal, roundabout).converged) << expression.name;
    const double off = largest_distance(direct.positions_mm, roundabout.positions_mm);
    record(expression.name + " at once, and by way of a smile muscle by muscle, default head",
           off < 1e-3 ? "same to " + figure(off) + " mm" : "differ by " + figure(off) + " mm",
           "paths agree, or the difference is reported",
           off < 1e-3 ? Outcome::kHolds : Outcome::kReported);
  }
}

}  // namespace
}  // namespace zygoma::hard
