#include "retarget/refine.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

namespace zygoma {
namespace {

using Head = HeadView::Parameters;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kNumHead = HeadView::kNumParameters;
constexpr int kYaw = 4;  // the pitch follows

// Workspace that the cost functions of a refiner share.
struct ReducedFrame {
  Eigen::VectorXd controls;
  NormalEquations equations;
  Eigen::LDLT<Eigen::MatrixXd> factor;
  Eigen::VectorXd residual;
  Eigen::MatrixXd root;
};

// A frame as a residual block of the size of its unknowns (frame_system.h).
class FrameCost final : public ceres::CostFunction {
 public:
  FrameCost(const FrameSystem& system, int num_controls, ReducedFrame& workspace)
      : system_(system), n_(num_controls), workspace_(workspace) {
    set_num_residuals(n_ + kNumHead + 1);
    mutable_parameter_block_sizes()->push_back(n_);
    mutable_parameter_block_sizes()->push_back(kNumHead);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    ReducedFrame& w = workspace_;
    w.controls = Eigen::Map<const Eigen::VectorXd>(x[0], n_);
    const Head head = Eigen::Map<const Head>(x[1]);
    Eigen::Map<Eigen::VectorXd> out(residuals, num_residuals());
    if (jacobians == nullptr) {  // nothing but their length matters
      out.setZero();
      out[n_ + kNumHead] = std::sqrt(system_.cost(w.controls, head));
      return true;
    }
    system_.normal_equations(w.controls, head, true, w.equations);
    reduce(w.equations, w.factor, w.residual, w.root);
    out = w.residual;
    const auto put = [&](double* to, Eigen::Index begin, Eigen::Index size) {
      if (to == nullptr) return;
      Eigen::Map<RowMajor> jacobian(to, num_residuals(), size);
      jacobian.topRows(n_ + kNumHead) = w.root.middleCols(begin, size);
      jacobian.bottomRows(1).setZero();
    };
    put(jacobians[0], 0, n_);
    put(jacobians[1], n_, kNumHead);
    return true;
  }

 private:
  const FrameSystem& system_;
  int n_;
  ReducedFrame& workspace_;
};

// Three instants: the acceleration of every entry is sum_j weight[j] x_j.
struct Acceleration {
  std::array<double, 3> weight{};

  Acceleration(double t0, double t1, double t2) {
    const double before = std::max(1e-6, t1 - t0);
    const double after = std::max(1e-6, t2 - t1);
    weight = {2.0 / (before * (before + after)),
              -2.0 / (before * after),
              2.0 / (after * (before + after))};
  }
};

// Accelerations, over their sigmas, of the entries of a block of `size` from `begin` on in three
// frames.
class SmoothCost final : public ceres::CostFunction {
 public:
  SmoothCost(const Acceleration& acceleration, int size, int begin, Eigen::VectorXd sigma)
      : acceleration_(acceleration), size_(size), begin_(begin), sigma_(std::move(sigma)) {
    set_num_residuals(static_cast<int>(sigma_.size()));
    mutable_parameter_block_sizes()->assign(3, size);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    for (int i = 0; i < num_residuals(); ++i) {
      residuals[i] = 0.0;
      for (std::size_t j = 0; j < 3; ++j) {
        residuals[i] += acceleration_.weight[j] * x[j][begin_ + i] / sigma_[i];
      }
    }
    for (std::size_t j = 0; jacobians != nullptr && j < 3; ++j) {
      if (jacobians[j] == nullptr) continue;
      std::fill_n(jacobians[j], num_residuals() * size_, 0.0);
      for (int i = 0; i < num_residuals(); ++i) {
        jacobians[j][i * size_ + begin_ + i] = acceleration_.weight[j] / sigma_[i];
      }
    }
    return true;
  }

 private:
  Acceleration acceleration_;
  int size_;
  int begin_;
  Eigen::VectorXd sigma_;
};

using HeldControls = std::vector<std::vector<int>>;  // per frame

// The unknowns of a window, and its gradient without Ceres.
struct Window {
  FrameScene& scene;
  ReducedFrame& workspace;
  std::vector<FrameSystem> systems{};
  std::vector<Eigen::VectorXd> controls{};
  std::vector<Head> heads{};
  std::vector<Acceleration> accelerations{};  // of frames t, t + 1, t + 2
  HeldControls held{};                        // controls that stay at their bound
  int num_fixed = 0;
  bool converged = false;
  int iterations = 0;

  void solve();
  void state(ceres::Problem& problem);
  void hold(ceres::Problem& problem);
  bool solve_free(ceres::Problem& problem, bool search_along_bounds);
  HeldControls pushed_outwards();
  Eigen::VectorXd gradient(std::size_t t);
};

// Half the derivative of everything that is minimised by the controls of a frame.
Eigen::VectorXd Window::gradient(std::size_t t) {
  systems[t].normal_equations(controls[t], heads[t], false, workspace.equations);
  Eigen::VectorXd result = workspace.equations.gradient.head(scene.num_controls());
  const Eigen::ArrayXd weight =
      (scene.options.acceleration_per_s2 * scene.agility).array().square().inverse();
  for (std::size_t j = 0; j < 3; ++j) {
    if (t < j || t - j >= accelerations.size()) continue;
    const std::size_t s = t - j;
    const auto& w = accelerations[s].weight;
    result.array() +=
        w[j] * weight *
        (w[0] * controls[s] + w[1] * controls[s + 1] + w[2] * controls[s + 2]).array();
  }
  return result;
}

// Controls at a bound whose cost falls only beyond it.
HeldControls Window::pushed_outwards() {
  constexpr double kAtBound = 1e-9;
  HeldControls result(systems.size());
  for (auto t = static_cast<std::size_t>(num_fixed); t < systems.size(); ++t) {
    const Eigen::VectorXd slope = gradient(t);
    for (int i = 0; i < scene.num_controls(); ++i) {
      const bool below = controls[t][i] <= kAtBound && slope[i] > 0.0;
      const bool above = controls[t][i] >= 1.0 - kAtBound && slope[i] < 0.0;
      if (below || above) result[t].push_back(i);
    }
  }
  return result;
}

// Ceres projects its steps on the bounds, which is slow when many controls want to leave [0, 1],
// and at rest nearly all do. So the controls that sit at a bound and are pushed outwards are held
// there while the others are solved for, and the set is checked again afterwards (Karush, Kuhn,
// Tucker).
void Window::solve() {
  constexpr int kMostRounds = 8;
  constexpr int kPlainRounds = 3;  // usual; more tell of sets that alternate
  ceres::Problem::Options ours;
  ours.disable_all_safety_checks = true;
  ceres::Problem problem(ours);
  state(problem);
  held = pushed_outwards();
  bool settled = true;
  for (int round = 0; round < kMostRounds; ++round) {
    hold(problem);
    settled = solve_free(problem, !settled || round >= kPlainRounds);
    HeldControls next = pushed_outwards();
    converged = settled && next == held;
    if (converged || iterations >= scene.options.max_iterations) break;
    held = std::move(next);
  }
}

void Window::state(ceres::Problem& problem) {
  const int n = scene.num_controls();
  for (auto t = static_cast<std::size_t>(num_fixed); t < systems.size(); ++t) {
    double* u = controls[t].data();
    problem.AddResidualBlock(new FrameCost(systems[t], n, workspace), nullptr, u, heads[t].data());
    for (int i = 0; i < n; ++i) {
      problem.SetParameterLowerBound(u, i, 0.0);
      problem.SetParameterUpperBound(u, i, 1.0);
    }
  }
  const RefineOptions& o = scene.options;
  for (std::size_t t = 0; t < accelerations.size(); ++t) {
    const Acceleration& a = accelerations[t];
    problem.AddResidualBlock(new SmoothCost(a, n, 0, o.acceleration_per_s2 * scene.agility),
                             nullptr,
                             controls[t].data(),
                             controls[t + 1].data(),
                             controls[t + 2].data());
    problem.AddResidualBlock(
        new SmoothCost(a, kNumHead, kYaw, Eigen::Vector2d::Constant(o.turn_acceleration_per_s2)),
        nullptr,
        heads[t].data(),
        heads[t + 1].data(),
        heads[t + 2].data());
  }
  for (std::size_t t = 0; t < std::min(static_cast<std::size_t>(num_fixed), systems.size()); ++t) {
    if (accelerations.empty()) break;
    problem.SetParameterBlockConstant(controls[t].data());
    problem.SetParameterBlockConstant(heads[t].data());
  }
}

void Window::hold(ceres::Problem& problem) {
  const int n = scene.num_controls();
  for (auto t = static_cast<std::size_t>(num_fixed); t < systems.size(); ++t) {
    double* u = controls[t].data();
    if (static_cast<int>(held[t].size()) == n) {
      problem.SetParameterBlockConstant(u);
      continue;
    }
    problem.SetParameterBlockVariable(u);
    problem.SetManifold(u, held[t].empty() ? nullptr : new ceres::SubsetManifold(n, held[t]));
  }
}

// One bounded solve over what is not held; true when it converged.
bool Window::solve_free(ceres::Problem& problem, bool search_along_bounds) {
  ceres::Solver::Options options;
  options.linear_solver_type =
      systems.size() == 1 ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  // Steps that run into a new bound creep; look at the held sets again before they cost much.
  options.max_num_iterations = std::min(6, scene.options.max_iterations - iterations);
  options.function_tolerance = scene.options.tolerance;
  options.parameter_tolerance = scene.options.tolerance;
  options.gradient_tolerance = 1e-4 * scene.options.tolerance;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // one thread, same bits
  // A line search along the projected step costs more than the step, and is worth it only where
  // plain steps fail.
  options.max_num_line_search_step_size_iterations = search_along_bounds ? 20 : 0;
  options.line_search_interpolation_type = ceres::BISECTION;  // the others ask for gradients
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e6;  // nearly linear: trust Gauss-Newton from the start
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  iterations += static_cast<int>(summary.iterations.size());
  return summary.termination_type == ceres::CONVERGENCE;
}

}  // namespace

struct Refiner::Impl {
  FrameScene scene;
  ReducedFrame workspace;

  Window window_of(std::span<const FrameObservation> frames, std::span<const RefinedFrame> start);
  static void hand_back(Window& window, std::span<RefinedFrame> solved);
};

Window Refiner::Impl::window_of(std::span<const FrameObservation> frames,
                                std::span<const RefinedFrame> start) {
  Window window{scene, workspace};
  window.systems.reserve(frames.size());
  for (std::size_t t = 0; t < frames.size(); ++t) {
    window.systems.emplace_back(scene, frames[t]);
    window.controls.push_back(start[t].controls.cwiseMax(0.0).cwiseMin(1.0));
    window.heads.push_back(start[t].head);
    if (t >= 2) {
      window.accelerations.emplace_back(
          frames[t - 2].time_s, frames[t - 1].time_s, frames[t].time_s);
    }
  }
  return window;
}

void Refiner::Impl::hand_back(Window& window, std::span<RefinedFrame> solved) {
  for (auto t = static_cast<std::size_t>(window.num_fixed); t < solved.size(); ++t) {
    RefinedFrame& out = solved[t];
    out.controls = window.controls[t];
    out.head = window.heads[t];
    out.converged = window.converged;
    out.iterations = window.iterations;
    Eigen::VectorXd slope = window.gradient(t);
    out.cost = window.workspace.equations.cost;
    for (const int i : window.held[t]) slope[i] = 0.0;
    out.optimality = slope.lpNorm<Eigen::Infinity>();
  }
}

Refiner::Refiner(const FaceResponse& response,
                 const NodeStack& neutral_mm,
                 double inverse_distance_per_mm,
                 const RefineOptions& options)
    : impl_(std::make_unique<Impl>(
          Impl{FrameScene(response, neutral_mm, inverse_distance_per_mm, options), {}})) {
  options.check();
}

Refiner::~Refiner() = default;

const RefineOptions& Refiner::options() const { return impl_->scene.options; }

RefinedFrame Refiner::refine(const FrameObservation& frame,
                             const RefinedFrame& start,
                             const ControlPrior& time) {
  Window window = impl_->window_of({&frame, 1}, {&start, 1});
  window.systems.front().lean_on(time);
  window.solve();
  RefinedFrame result;
  Impl::hand_back(window, {&result, 1});
  return result;
}

void Refiner::refine_window(std::span<const FrameObservation> frames,
                            std::span<RefinedFrame> solved,
                            int num_fixed) {
  assert(frames.size() == solved.size());
  Window window = impl_->window_of(frames, solved);
  window.num_fixed = num_fixed;
  window.solve();
  Impl::hand_back(window, solved);
}

FramePosterior Refiner::posterior(const FrameObservation& frame, const RefinedFrame& solved) {
  FrameScene& scene = impl_->scene;
  const Eigen::Index n = scene.num_controls();
  const Eigen::Index size = scene.num_unknowns();
  const FrameSystem system(scene, frame);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size, size);
  const auto sigma_of = [&](const Eigen::MatrixXd& covariance) {
    return Eigen::VectorXd(covariance.diagonal().head(n).cwiseMax(0.0).cwiseSqrt());
  };

  FramePosterior result;
  NormalEquations prior{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), 0.0};
  system.add_priors(solved.controls, solved.head, prior);
  result.prior_sigma = sigma_of(prior.information.ldlt().solve(identity));
  NormalEquations all;
  system.normal_equations(solved.controls, solved.head, true, all);
  const Eigen::MatrixXd covariance = all.information.ldlt().solve(identity);
  result.sigma = sigma_of(covariance);

  // With one sigma at every node of a contour, its rows J_c move the estimate by C J_c^T.
  result.influence = Eigen::MatrixXd::Zero(n, kNumContours);
  for (int c = 0; c < kNumContours; ++c) {
    const auto [first, rows] = system.rows_of(c);
    if (rows == 0) continue;
    result.influence.col(c) =
        (covariance.topRows(n) * scene.jacobian.middleRows(first, rows).transpose())
            .rowwise()
            .norm();
    result.residual_mm[static_cast<std::size_t>(c)] = system.misfit_mm(c, solved.head);
  }
  return result;
}

}  // namespace zygoma
