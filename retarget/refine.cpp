#include "retarget/refine.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr int kNumHead = HeadView::kNumParameters;
constexpr int kYaw = 4;
constexpr int kPitch = 5;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// How weakly a contour holds its nodes along itself, as a multiple of the sigma across. Ends of
// lips, brows and lids are points that the tracker measures; ends of the others slide.
struct Slide {
  double inside;
  double end;
};
constexpr Slide slide_of(int contour) {
  if (contour == kUpperLipContour || contour == kLowerLipContour) return {2.5, 1.0};
  if (contour == kBrowLeftContour || contour == kBrowRightContour) return {2.5, 1.5};
  if (contour == kNoseTipContour) return {2.0, 2.0};
  if (is_eyelid(contour)) return {4.0, 1.0};
  return {4.0, 4.0};
}

Point2 tangent_at(const NodeStack& nodes, int contour, int node) {
  const int before = std::max(first_node(contour), node - 1);
  const int after = std::min(last_node(contour), node + 1);
  const Point2 chord = nodes.col(after) - nodes.col(before);
  const double length = chord.norm();
  return length > 0.0 ? Point2(chord / length) : Point2(1.0, 0.0);
}

using NamePair = std::pair<const char*, const char*>;

// Both sides of pairs of muscles, as indices.
std::vector<std::pair<int, int>> indices_of(const std::vector<NamePair>& pairs,
                                            const std::vector<std::string>& muscles) {
  const auto find = [&](const std::string& name) {
    const auto at = std::find(muscles.begin(), muscles.end(), name);
    return at == muscles.end() ? -1 : static_cast<int>(at - muscles.begin());
  };
  std::vector<std::pair<int, int>> result;
  for (const auto& [first, second] : pairs) {
    for (const char* side : {"_L", "_R"}) {
      const int a = find(std::string(first) + side);
      const int b = find(std::string(second) + side);
      if (a >= 0 && b >= 0) result.emplace_back(a, b);
    }
  }
  return result;
}

// Cauchy's loss as a residual: the vector r shrunk to the length sqrt(rho(r.r)), so that its square
// is the loss exactly. Returns the matrix that its derivative is multiplied with.
Eigen::Matrix2d shrink_outlier(double width, Eigen::Vector2d& r) {
  const double square = width * width;
  const double s = r.squaredNorm();
  const double ratio = s / square;
  // g = sqrt(rho / s), rho = square log(1 + ratio); its series near zero.
  const bool tiny = ratio < 1e-6;
  const double g = tiny ? 1.0 - 0.25 * ratio : std::sqrt(std::log1p(ratio) / ratio);
  const double slope = tiny ? -0.25 / square : 0.5 * (1.0 / (1.0 + ratio) - g * g) / (g * s);
  const Eigen::Matrix2d turn = g * Eigen::Matrix2d::Identity() + 2.0 * slope * r * r.transpose();
  r *= g;
  return turn;
}

// What all frames share.
struct Scene {
  const FaceResponse* response = nullptr;
  NodeStack neutral_mm = NodeStack::Zero();
  double inverse_distance_per_mm = 0.0;
  std::vector<std::pair<int, int>> antagonists;
  std::vector<std::pair<int, int>> tied;
  RefineOptions options;

  // Workspace of one evaluation.
  mutable Eigen::VectorXd displacement;
  mutable Eigen::MatrixXd slope;

  int num_controls() const { return response->num_controls(); }
  int num_priors() const {
    return 2 * num_controls() + kNumHead + static_cast<int>(antagonists.size() + tied.size());
  }
  int num_residuals() const { return 2 * kNumNodes + num_priors(); }
};

// One frame as a least-squares problem.
struct FrameSystem {
  const Scene* scene = nullptr;
  const FrameObservation* frame = nullptr;
  ControlPrior time{{}, kInfinite};
  std::array<Eigen::Matrix2d, kNumNodes> whitening;  // zero: the node is not used
  std::array<bool, kNumNodes> used{};

  FrameSystem(const Scene& shared, const FrameObservation& observation)
      : scene(&shared), frame(&observation) {
    for (int c = 0; c < kNumContours; ++c) whiten(c);
  }

  void whiten(int contour) {
    const auto index = static_cast<std::size_t>(contour);
    const bool seen =
        frame->sigma_mm[index] > 0.0 && (scene->response->has_contour[index] || is_eyelid(contour));
    // Nodes of one contour err together: n nodes carry the evidence of a few.
    const double together =
        std::sqrt(std::max(1.0, num_nodes(contour) / scene->options.independent_nodes));
    for (int k = first_node(contour); k <= last_node(contour); ++k) {
      const auto node = static_cast<std::size_t>(k);
      const bool is_end = k == first_node(contour) || k == last_node(contour);
      // A lid moves by muscles that are not estimated; its corners are fixed to the skull.
      used[node] = seen && (is_end || !is_eyelid(contour));
      whitening[node].setZero();
      if (!used[node]) continue;
      const double gone = (frame->mm.col(k) - scene->neutral_mm.col(k)).norm();
      const double sigma =
          std::hypot(frame->sigma_mm[index], scene->options.relative_error * gone) *
          (is_eyelid(contour) ? 1.0 : together);
      const Point2 along = tangent_at(frame->mm, contour, k);
      const double slide = is_end ? slide_of(contour).end : slide_of(contour).inside;
      whitening[node].row(0) = Point2(-along.y(), along.x()).transpose() / sigma;
      whitening[node].row(1) = along.transpose() / (slide * sigma);
    }
  }

  // The response, corrected; in the scene's workspace.
  void displace(const Eigen::VectorXd& u, bool with_slope) const {
    scene->response->displace(u, scene->displacement, with_slope ? &scene->slope : nullptr);
    if (frame->correction == nullptr) return;
    const ModelCorrection& more = *frame->correction;
    scene->displacement += more.offset_mm;
    if (more.slope_mm.size() == 0) return;
    scene->displacement.noalias() += more.slope_mm * (u - more.at);
    if (with_slope) scene->slope += more.slope_mm;
  }

  double depth(int node) const { return scene->response->rest_depth_mm[node]; }

  // Unweighted misfit of all nodes, mm, after displace().
  HeadView::Sight see(int node, const HeadView& view) const {
    const Point2 place = scene->neutral_mm.col(node) + scene->displacement.segment<2>(2 * node);
    HeadView::Sight sight = view.see(place, depth(node));
    sight.at -= frame->mm.col(node);
    return sight;
  }

  // Residuals and, where not null, their derivatives (row-major, one row per residual).
  void evaluate(const double* controls,
                const double* head_parameters,
                double* residual,
                double* by_controls,
                double* by_head) const {
    const Eigen::Index n = scene->num_controls();
    const Eigen::Map<const Eigen::VectorXd> u(controls, n);
    const HeadView view(Eigen::Map<const HeadView::Parameters>(head_parameters),
                        scene->inverse_distance_per_mm);
    displace(u, by_controls != nullptr);
    Eigen::Map<RowMajor> ju(by_controls, by_controls == nullptr ? 0 : scene->num_residuals(), n);
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kNumHead, Eigen::RowMajor>> jh(
        by_head, by_head == nullptr ? 0 : scene->num_residuals(), kNumHead);
    for (int k = 0; k < kNumNodes; ++k) {
      const auto node = static_cast<std::size_t>(k);
      Eigen::Map<Eigen::Vector2d> out(residual + 2 * k);
      if (!used[node]) {
        out.setZero();
        if (by_controls != nullptr) ju.middleRows<2>(2 * k).setZero();
        if (by_head != nullptr) jh.middleRows<2>(2 * k).setZero();
        continue;
      }
      const HeadView::Sight sight = see(k, view);
      Eigen::Vector2d r = whitening[node] * sight.at;
      const Eigen::Matrix2d weight =
          shrink_outlier(scene->options.outlier_sigmas, r) * whitening[node];
      out = r;
      if (by_controls != nullptr) {
        ju.middleRows<2>(2 * k).noalias() =
            (weight * sight.by_node) * scene->slope.middleRows<2>(2 * k);
      }
      if (by_head != nullptr) jh.middleRows<2>(2 * k).noalias() = weight * sight.by_head;
    }
    priors(controls, head_parameters, residual, by_controls, by_head);
  }

  // Residuals of unit variance, after those of the nodes.
  void priors(const double* u,
              const double* head,
              double* residual,
              double* by_controls,
              double* by_head) const {
    const RefineOptions& options = scene->options;
    const int n = scene->num_controls();
    const int begin = 2 * kNumNodes;
    const int rows = scene->num_priors();
    Eigen::Map<RowMajor> ju(by_controls, by_controls == nullptr ? 0 : begin + rows, n);
    Eigen::Map<RowMajor> jh(by_head, by_head == nullptr ? 0 : begin + rows, kNumHead);
    if (by_controls != nullptr) ju.bottomRows(rows).setZero();
    if (by_head != nullptr) jh.bottomRows(rows).setZero();
    const auto put = [&](int row, int column, double slope) {
      if (by_controls != nullptr) ju(row, column) = slope;
    };
    int row = begin;
    const double time_weight = std::isfinite(time.sigma) ? 1.0 / time.sigma : 0.0;
    for (int i = 0; i < n; ++i, ++row) {
      residual[row] = (u[i] + options.rest_pull) / options.ridge_sigma;
      put(row, i, 1.0 / options.ridge_sigma);
      residual[row + n] = time_weight > 0.0 ? time_weight * (u[i] - time.mean[i]) : 0.0;
      put(row + n, i, time_weight);
    }
    row += n;
    const std::array<double, kNumHead> head_sigma{options.head_scale_sigma,
                                                  options.head_scale_sigma,
                                                  options.head_shift_sigma_mm,
                                                  options.head_shift_sigma_mm,
                                                  options.head_turn_sigma_rad,
                                                  options.head_turn_sigma_rad};
    for (int i = 0; i < kNumHead; ++i, ++row) {
      const double weight = 1.0 / head_sigma[static_cast<std::size_t>(i)];
      residual[row] = weight * head[i];
      if (by_head != nullptr) jh(row, i) = weight;
    }
    for (const auto& [a, b] : scene->antagonists) {
      residual[row] = u[a] * u[b] / options.antagonist_sigma;
      put(row, a, u[b] / options.antagonist_sigma);
      put(row, b, u[a] / options.antagonist_sigma);
      ++row;
    }
    for (const auto& [a, b] : scene->tied) {
      residual[row] = (u[a] - u[b]) / options.tie_sigma;
      put(row, a, 1.0 / options.tie_sigma);
      put(row, b, -1.0 / options.tie_sigma);
      ++row;
    }
  }
};

class FrameCost final : public ceres::CostFunction {
 public:
  explicit FrameCost(const FrameSystem& system) : system_(system) {
    set_num_residuals(system.scene->num_residuals());
    mutable_parameter_block_sizes()->push_back(system.scene->num_controls());
    mutable_parameter_block_sizes()->push_back(kNumHead);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    system_.evaluate(x[0],
                     x[1],
                     residuals,
                     jacobians == nullptr ? nullptr : jacobians[0],
                     jacobians == nullptr ? nullptr : jacobians[1]);
    return true;
  }

 private:
  const FrameSystem& system_;
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

// Accelerations of a block in three frames, over their sigmas; an infinite sigma leaves a row out.
class SmoothCost final : public ceres::CostFunction {
 public:
  SmoothCost(const Acceleration& acceleration, std::vector<double> sigma)
      : acceleration_(acceleration), sigma_(std::move(sigma)) {
    const int n = static_cast<int>(sigma_.size());
    set_num_residuals(n);
    mutable_parameter_block_sizes()->assign(3, n);
  }
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const std::size_t n = sigma_.size();
    for (std::size_t i = 0; i < n; ++i) {
      residuals[i] = 0.0;
      for (std::size_t j = 0; j < 3; ++j) {
        residuals[i] += acceleration_.weight[j] * x[j][i] / sigma_[i];
      }
    }
    for (std::size_t j = 0; jacobians != nullptr && j < 3; ++j) {
      if (jacobians[j] == nullptr) continue;
      std::fill_n(jacobians[j], n * n, 0.0);
      for (std::size_t i = 0; i < n; ++i) {
        jacobians[j][i * n + i] = acceleration_.weight[j] / sigma_[i];
      }
    }
    return true;
  }

 private:
  Acceleration acceleration_;
  std::vector<double> sigma_;
};

// The unknowns of a window, and its gradient without Ceres.
struct Window {
  const Scene& scene;
  std::vector<FrameSystem> systems;
  std::vector<Eigen::VectorXd> controls;
  std::vector<HeadView::Parameters> heads;
  std::vector<Acceleration> accelerations;  // of frames t, t + 1, t + 2
  std::vector<std::vector<int>> held;       // per frame, controls that stay at their bound
  int num_fixed = 0;
  bool converged = false;
  int iterations = 0;
  RowMajor by_controls;  // workspace
  Eigen::VectorXd residual;

  void solve();
  bool solve_free();
  std::vector<std::vector<int>> pushed_outwards();
  Eigen::VectorXd gradient(std::size_t t);
};

// Half the derivative of everything that is minimised by the controls of a frame.
Eigen::VectorXd Window::gradient(std::size_t t) {
  residual.resize(scene.num_residuals());
  by_controls.resize(scene.num_residuals(), scene.num_controls());
  systems[t].evaluate(
      controls[t].data(), heads[t].data(), residual.data(), by_controls.data(), nullptr);
  Eigen::VectorXd result = by_controls.transpose() * residual;
  const double weight = 1.0 / scene.options.acceleration_per_s2;
  for (std::size_t j = 0; j < 3; ++j) {
    if (t < j || t - j >= accelerations.size()) continue;
    const std::size_t s = t - j;
    const auto& w = accelerations[s].weight;
    const double square = w[j] * weight * weight;
    result += square * (w[0] * controls[s] + w[1] * controls[s + 1] + w[2] * controls[s + 2]);
  }
  return result;
}

// Controls at a bound whose cost falls only beyond it.
std::vector<std::vector<int>> Window::pushed_outwards() {
  constexpr double kAtBound = 1e-9;
  std::vector<std::vector<int>> result(systems.size());
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
  held = pushed_outwards();
  for (int round = 0; round < kMostRounds; ++round) {
    const bool settled = solve_free();
    std::vector<std::vector<int>> next = pushed_outwards();
    converged = settled && next == held;
    if (converged || iterations >= scene.options.max_iterations) break;
    held = std::move(next);
  }
}

// One bounded solve over what is not held; true when it converged.
bool Window::solve_free() {
  ceres::Problem::Options ours;
  ours.disable_all_safety_checks = true;
  ceres::Problem problem(ours);
  const int n = scene.num_controls();
  const auto fixed = static_cast<std::size_t>(num_fixed);
  for (std::size_t t = fixed; t < systems.size(); ++t) {
    double* u = controls[t].data();
    problem.AddResidualBlock(new FrameCost(systems[t]), nullptr, u, heads[t].data());
    if (static_cast<int>(held[t].size()) == n) {
      problem.SetParameterBlockConstant(u);
      continue;
    }
    for (int i = 0; i < n; ++i) {
      problem.SetParameterLowerBound(u, i, 0.0);
      problem.SetParameterUpperBound(u, i, 1.0);
    }
    if (!held[t].empty()) problem.SetManifold(u, new ceres::SubsetManifold(n, held[t]));
  }
  const auto sigmas = static_cast<std::size_t>(n);
  const std::vector<double> control_sigma(sigmas, scene.options.acceleration_per_s2);
  std::vector<double> head_sigma(kNumHead, kInfinite);
  head_sigma[kYaw] = head_sigma[kPitch] = scene.options.turn_acceleration_per_s2;
  for (std::size_t t = 0; t < accelerations.size(); ++t) {
    problem.AddResidualBlock(new SmoothCost(accelerations[t], control_sigma),
                             nullptr,
                             controls[t].data(),
                             controls[t + 1].data(),
                             controls[t + 2].data());
    problem.AddResidualBlock(new SmoothCost(accelerations[t], head_sigma),
                             nullptr,
                             heads[t].data(),
                             heads[t + 1].data(),
                             heads[t + 2].data());
  }
  for (std::size_t t = 0; t < std::min(fixed, systems.size()); ++t) {
    if (accelerations.empty()) break;
    problem.SetParameterBlockConstant(controls[t].data());
    problem.SetParameterBlockConstant(heads[t].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type =
      systems.size() == 1 ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  // Steps that run into a new bound creep; look at the held sets again before they cost much.
  options.max_num_iterations = std::min(6, scene.options.max_iterations - iterations);
  options.function_tolerance = scene.options.tolerance;
  options.parameter_tolerance = scene.options.tolerance;
  options.gradient_tolerance = 1e-4 * scene.options.tolerance;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // one thread, same bits
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
  Scene scene;

  Window window_of(std::span<const FrameObservation> frames, std::span<const RefinedFrame> start);
  static void hand_back(Window& window, std::span<RefinedFrame> solved);
};

Window Refiner::Impl::window_of(std::span<const FrameObservation> frames,
                                std::span<const RefinedFrame> start) {
  Window window{scene, {}, {}, {}, {}, {}, 0, false, 0, {}, {}};
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
    out.cost = window.residual.squaredNorm();
    for (const int i : window.held[t]) slope[i] = 0.0;
    out.optimality = slope.lpNorm<Eigen::Infinity>();
  }
}

void RefineOptions::check() const {
  const auto within = [](const char* name, double value, double low, double high) {
    require(value >= low && value <= high,
            std::string(name) + " is " + std::to_string(value) + "; expected a value in [" +
                std::to_string(low) + ", " + std::to_string(high) + "]");
  };
  within("outlier_sigmas", outlier_sigmas, 1.0, 1e6);
  within("ridge_sigma", ridge_sigma, 0.05, 1e6);
  within("rest_pull", rest_pull, 0.0, 1.0);
  within("antagonist_sigma", antagonist_sigma, 0.01, 1e6);
  within("tie_sigma", tie_sigma, 0.01, 1e6);
  within("head_scale_sigma", head_scale_sigma, 1e-4, 10.0);
  within("head_shift_sigma_mm", head_shift_sigma_mm, 0.01, 1000.0);
  within("head_turn_sigma_rad", head_turn_sigma_rad, 1e-4, 10.0);
  within("relative_error", relative_error, 0.0, 10.0);
  within("independent_nodes", independent_nodes, 1.0, 100.0);
  within("fastest_per_s", fastest_per_s, 0.1, 1e9);
  within("acceleration_per_s2", acceleration_per_s2, 1.0, 1e9);
  within("turn_acceleration_per_s2", turn_acceleration_per_s2, 0.01, 1e9);
  within("window_frames", window_frames, 1.0, 1000.0);
  within("lookahead_frames", lookahead_frames, 0.0, 1000.0);
  within("tolerance", tolerance, 1e-15, 0.1);
  within("max_iterations", max_iterations, 1.0, 1000.0);
}

Refiner::Refiner(const FaceResponse& response,
                 const NodeStack& neutral_mm,
                 double inverse_distance_per_mm,
                 const RefineOptions& options)
    : impl_(std::make_unique<Impl>()) {
  options.check();
  Scene& scene = impl_->scene;
  scene.response = &response;
  scene.neutral_mm = neutral_mm;
  scene.inverse_distance_per_mm = inverse_distance_per_mm;
  scene.options = options;
  scene.antagonists = indices_of({{"occipitofrontalis_inner", "corrugator_supercilii"},
                                  {"occipitofrontalis_major", "corrugator_supercilii"},
                                  {"zygomaticus_major", "depressor_anguli_oris"},
                                  {"levator_labii_superioris", "depressor_labii_inferioris"}},
                                 response.muscles);
  scene.tied =
      indices_of({{"occipitofrontalis_major", "occipitofrontalis_inner"}}, response.muscles);
}

Refiner::~Refiner() = default;

const RefineOptions& Refiner::options() const { return impl_->scene.options; }

RefinedFrame Refiner::refine(const FrameObservation& frame,
                             const RefinedFrame& start,
                             const ControlPrior& time) {
  Window window = impl_->window_of({&frame, 1}, {&start, 1});
  window.systems.front().time = time;
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
  const Scene& scene = impl_->scene;
  const Eigen::Index n = scene.num_controls();
  const Eigen::Index size = n + kNumHead;
  const FrameSystem system(scene, frame);
  RowMajor by_controls(scene.num_residuals(), n);
  RowMajor by_head(scene.num_residuals(), kNumHead);
  Eigen::VectorXd residual(scene.num_residuals());
  system.evaluate(solved.controls.data(),
                  solved.head.data(),
                  residual.data(),
                  by_controls.data(),
                  by_head.data());
  const auto square = [&](Eigen::Index begin, Eigen::Index rows) {
    Eigen::MatrixXd j(rows, size);
    j << by_controls.middleRows(begin, rows), by_head.middleRows(begin, rows);
    return Eigen::MatrixXd(j.transpose() * j);
  };
  const auto sigma_of = [&](const Eigen::MatrixXd& covariance) {
    return Eigen::VectorXd(covariance.diagonal().head(n).cwiseMax(0.0).cwiseSqrt());
  };
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size, size);
  Eigen::MatrixXd information = square(2 * kNumNodes, scene.num_priors());

  FramePosterior result;
  result.prior_sigma = sigma_of(information.ldlt().solve(identity));
  std::array<Eigen::MatrixXd, kNumContours> evidence;
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    evidence[index] = square(2 * first_node(c), 2 * num_nodes(c));
    information += evidence[index];
  }
  const Eigen::MatrixXd covariance = information.ldlt().solve(identity);
  result.sigma = sigma_of(covariance);
  result.influence.resize(n, kNumContours);
  const HeadView view(solved.head, scene.inverse_distance_per_mm);
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    result.influence.col(c) = sigma_of(covariance * evidence[index] * covariance);
    double sum = 0.0;
    int count = 0;
    for (int k = first_node(c); k <= last_node(c); ++k) {
      if (!system.used[static_cast<std::size_t>(k)]) continue;
      sum += system.see(k, view).at.squaredNorm();
      ++count;
    }
    result.residual_mm[index] = count > 0 ? std::sqrt(sum / count) : 0.0;
  }
  return result;
}

}  // namespace zygoma
