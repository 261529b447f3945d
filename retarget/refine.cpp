#include "retarget/refine.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr int kNumHead = 6;  // a, b, t_x, t_y, yaw, pitch

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// How weakly a contour holds its nodes along itself, as a multiple of the sigma across. Ends of
// lips and brows are points that the tracker measures; ends of the others slide.
struct Slide {
  double inside;
  double end;
};
constexpr Slide slide_of(int contour) {
  if (contour == kUpperLipContour || contour == kLowerLipContour) return {2.5, 1.0};
  if (contour == kBrowLeftContour || contour == kBrowRightContour) return {2.5, 1.5};
  if (contour == kNoseTipContour) return {2.0, 2.0};
  return {4.0, 4.0};
}

// What the cost functions read; the observation changes from frame to frame.
struct Scene {
  const FaceResponse* response = nullptr;
  NodeStack neutral_mm = NodeStack::Zero();
  std::array<Eigen::Matrix2d, kNumNodes> unit_whitening;  // for sigma = 1 mm
  std::array<Eigen::Matrix2d, kNumNodes> turn;            // columns yaw, pitch
  std::vector<std::pair<int, int>> antagonists;
  RefineOptions options;

  FrameObservation frame;
  std::array<double, kNumNodes> inverse_sigma{};  // 0: the node is not used
  ControlPrior time;

  int num_controls() const { return response->num_controls(); }
  int num_parameters() const { return num_controls() + kNumHead; }
  int num_priors() const {
    return 2 * num_controls() + kNumHead + static_cast<int>(antagonists.size());
  }

  // Unweighted misfit of a node, mm, and its derivative (2 x num_parameters).
  Point2 misfit(int node,
                const double* x,
                Eigen::Matrix<double, 2, Eigen::Dynamic>* jacobian) const {
    const int n = num_controls();
    const double* h = x + n;
    const Point2 y = frame.mm.col(node);
    const Eigen::Matrix2d& t = turn[static_cast<std::size_t>(node)];
    if (jacobian != nullptr) {
      Eigen::Matrix<double, 2, Eigen::Dynamic> moved(2, n);
      const Point2 d = response->displacement(node, x, &moved);
      jacobian->leftCols(n) = -moved;
      jacobian->col(n) = y;
      jacobian->col(n + 1) = Point2(-y.y(), y.x());
      jacobian->col(n + 2) = Point2(1.0, 0.0);
      jacobian->col(n + 3) = Point2(0.0, 1.0);
      jacobian->rightCols<2>() = -t;
      return head_removed(y, h) - neutral_mm.col(node) - d - t * Point2(h[4], h[5]);
    }
    return head_removed(y, h) - neutral_mm.col(node) - response->displacement(node, x) -
           t * Point2(h[4], h[5]);
  }

  static Point2 head_removed(const Point2& y, const double* h) {
    return {y.x() + h[0] * y.x() - h[1] * y.y() + h[2], y.y() + h[1] * y.x() + h[0] * y.y() + h[3]};
  }

  Eigen::Matrix2d whitening(int node) const {
    const auto k = static_cast<std::size_t>(node);
    return inverse_sigma[k] * unit_whitening[k];
  }

  // Priors as residuals of unit variance.
  void priors(const double* x, double* residual, RowMajor* jacobian) const {
    const int n = num_controls();
    const double time_weight = std::isfinite(time.sigma) ? 1.0 / time.sigma : 0.0;
    if (jacobian != nullptr) jacobian->setZero(num_priors(), num_parameters());
    const auto put = [&](int row, int column, double value, double slope) {
      residual[row] = value;
      if (jacobian != nullptr) (*jacobian)(row, column) = slope;
    };
    for (int i = 0; i < n; ++i) {
      put(i, i, x[i] / options.ridge_sigma, 1.0 / options.ridge_sigma);
      const double mean = time_weight > 0.0 ? time.mean[i] : 0.0;
      put(n + i, i, time_weight * (x[i] - mean), time_weight);
    }
    const std::array<double, kNumHead> head_sigma{options.head_scale_sigma,
                                                  options.head_scale_sigma,
                                                  options.head_shift_sigma_mm,
                                                  options.head_shift_sigma_mm,
                                                  options.head_turn_sigma_rad,
                                                  options.head_turn_sigma_rad};
    for (int i = 0; i < kNumHead; ++i) {
      const double sigma = head_sigma[static_cast<std::size_t>(i)];
      put(2 * n + i, n + i, x[n + i] / sigma, 1.0 / sigma);
    }
    int row = 2 * n + kNumHead;
    for (const auto& [a, b] : antagonists) {
      put(row, a, x[a] * x[b] / options.antagonist_sigma, x[b] / options.antagonist_sigma);
      if (jacobian != nullptr) (*jacobian)(row, b) = x[a] / options.antagonist_sigma;
      ++row;
    }
  }
};

class NodeCost final : public ceres::CostFunction {
 public:
  NodeCost(const Scene& scene, int node) : scene_(scene), node_(node) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->push_back(scene.num_parameters());
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Matrix2d whitening = scene_.whitening(node_);
    Eigen::Map<Eigen::Vector2d> r(residuals);
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      r = whitening * scene_.misfit(node_, x[0], nullptr);
      return true;
    }
    Eigen::Matrix<double, 2, Eigen::Dynamic> slope(2, scene_.num_parameters());
    r = whitening * scene_.misfit(node_, x[0], &slope);
    Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>>(
        jacobians[0], 2, scene_.num_parameters()) = whitening * slope;
    return true;
  }

 private:
  const Scene& scene_;
  int node_;
};

class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const Scene& scene) : scene_(scene) {
    set_num_residuals(scene.num_priors());
    mutable_parameter_block_sizes()->push_back(scene.num_parameters());
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr || jacobians[0] == nullptr) {
      scene_.priors(x[0], residuals, nullptr);
      return true;
    }
    RowMajor slope;
    scene_.priors(x[0], residuals, &slope);
    Eigen::Map<RowMajor>(jacobians[0], slope.rows(), slope.cols()) = slope;
    return true;
  }

 private:
  const Scene& scene_;
};

std::vector<std::pair<int, int>> antagonists_of(const std::vector<std::string>& muscles) {
  constexpr std::array<std::pair<const char*, const char*>, 4> kPairs{{
      {"occipitofrontalis_inner", "corrugator_supercilii"},
      {"occipitofrontalis_major", "corrugator_supercilii"},
      {"zygomaticus_major", "depressor_anguli_oris"},
      {"levator_labii_superioris", "depressor_labii_inferioris"},
  }};
  const auto find = [&](const std::string& name) {
    const auto at = std::find(muscles.begin(), muscles.end(), name);
    return at == muscles.end() ? -1 : static_cast<int>(at - muscles.begin());
  };
  std::vector<std::pair<int, int>> result;
  for (const auto& [raises, lowers] : kPairs) {
    for (const char* side : {"_L", "_R"}) {
      const int a = find(std::string(raises) + side);
      const int b = find(std::string(lowers) + side);
      if (a >= 0 && b >= 0) result.emplace_back(a, b);
    }
  }
  return result;
}

Point2 tangent_at(const NodeStack& nodes, int contour, int node) {
  const int before = std::max(first_node(contour), node - 1);
  const int after = std::min(last_node(contour), node + 1);
  const Point2 chord = nodes.col(after) - nodes.col(before);
  const double length = chord.norm();
  return length > 0.0 ? Point2(chord / length) : Point2(1.0, 0.0);
}

}  // namespace

struct Refiner::Impl {
  Scene scene;
  std::deque<NodeCost> node_costs;  // cost functions do not move
  std::unique_ptr<PriorCost> prior_cost;
  std::unique_ptr<ceres::LossFunction> loss;
  std::vector<double> x;
  std::unique_ptr<ceres::Problem> problem;
  bool converged = false;
  int iterations = 0;

  void pose_problem();
  void load(const FrameObservation& frame, const ControlPrior& time);
  void solve();
  std::vector<int> pushed_outwards() const;
  void normal_equations(Eigen::MatrixXd* information, Eigen::VectorXd* gradient) const;
  Eigen::VectorXd posterior_sigma() const;
  std::array<double, kNumContours> residuals_mm() const;
};

void Refiner::Impl::pose_problem() {
  ceres::Problem::Options ours;
  ours.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ours.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ours.disable_all_safety_checks = true;
  problem = std::make_unique<ceres::Problem>(ours);
  x.assign(static_cast<std::size_t>(scene.num_parameters()), 0.0);
  loss = std::make_unique<ceres::CauchyLoss>(scene.options.outlier_sigmas);
  prior_cost = std::make_unique<PriorCost>(scene);
  for (int k = 0; k < kNumNodes; ++k) node_costs.emplace_back(scene, k);
  problem->AddParameterBlock(x.data(), scene.num_parameters());
  for (NodeCost& cost : node_costs) problem->AddResidualBlock(&cost, loss.get(), x.data());
  problem->AddResidualBlock(prior_cost.get(), nullptr, x.data());
  for (int i = 0; i < scene.num_controls(); ++i) {
    problem->SetParameterLowerBound(x.data(), i, 0.0);
    problem->SetParameterUpperBound(x.data(), i, 1.0);
  }
}

void Refiner::Impl::load(const FrameObservation& frame, const ControlPrior& time) {
  scene.frame = frame;
  scene.time = time;
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    const bool used = frame.sigma_mm[index] > 0.0 && scene.response->has_contour[index];
    // Nodes of one contour err together: n nodes carry the evidence of a few.
    const double together =
        std::sqrt(std::max(1.0, num_nodes(c) / scene.options.independent_nodes));
    const double weight = used ? 1.0 / (frame.sigma_mm[index] * together) : 0.0;
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      scene.inverse_sigma[static_cast<std::size_t>(k)] = weight;
    }
  }
}

// Ceres projects its steps on the bounds, which is slow when many controls want to leave [0, 1],
// and at rest nearly all do. So the controls that sit at a bound and are pushed outwards are held
// there while the others are solved for, and the set is checked again afterwards (Karush, Kuhn,
// Tucker).
void Refiner::Impl::solve() {
  constexpr int kMostRounds = 8;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = scene.options.max_iterations;
  options.function_tolerance = 1e-7;
  options.parameter_tolerance = 1e-6;
  options.gradient_tolerance = 1e-8;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e6;  // nearly linear: trust Gauss-Newton from the start
  converged = false;
  iterations = 0;
  std::vector<int> held = pushed_outwards();
  for (int round = 0; round < kMostRounds; ++round) {
    problem->SetManifold(
        x.data(), held.empty() ? nullptr : new ceres::SubsetManifold(scene.num_parameters(), held));
    // Steps that run into a new bound creep; look at the set again before they cost much.
    options.max_num_iterations = std::min(6, scene.options.max_iterations - iterations);
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem.get(), &summary);
    iterations += static_cast<int>(summary.iterations.size());
    std::vector<int> next = pushed_outwards();
    const bool same = next == held;
    held = std::move(next);
    converged = same && summary.termination_type == ceres::CONVERGENCE;
    if (converged || iterations >= scene.options.max_iterations) break;
  }
}

// Controls at a bound whose cost falls only beyond it.
std::vector<int> Refiner::Impl::pushed_outwards() const {
  constexpr double kAtBound = 1e-9;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(scene.num_parameters());
  normal_equations(nullptr, &gradient);
  std::vector<int> result;
  for (int i = 0; i < scene.num_controls(); ++i) {
    const double value = x[static_cast<std::size_t>(i)];
    const bool below = value <= kAtBound && gradient[i] > 0.0;
    const bool above = value >= 1.0 - kAtBound && gradient[i] < 0.0;
    if (below || above) result.push_back(i);
  }
  return result;
}

// J^T J and J^T r of everything that is minimised, at x.
void Refiner::Impl::normal_equations(Eigen::MatrixXd* information,
                                     Eigen::VectorXd* gradient) const {
  RowMajor slope;
  Eigen::VectorXd residual(scene.num_priors());
  scene.priors(x.data(), residual.data(), &slope);
  if (information != nullptr) *information = slope.transpose() * slope;
  if (gradient != nullptr) *gradient = slope.transpose() * residual;
  const double width = scene.options.outlier_sigmas * scene.options.outlier_sigmas;
  Eigen::Matrix<double, 2, Eigen::Dynamic> white(2, scene.num_parameters());
  for (int k = 0; k < kNumNodes; ++k) {
    if (scene.inverse_sigma[static_cast<std::size_t>(k)] <= 0.0) continue;
    const Eigen::Matrix2d whitening = scene.whitening(k);
    const Eigen::Vector2d r = whitening * scene.misfit(k, x.data(), &white);
    white = (whitening * white).eval();
    const double robust = 1.0 / (1.0 + r.squaredNorm() / width);
    if (information != nullptr) information->noalias() += robust * white.transpose() * white;
    if (gradient != nullptr) gradient->noalias() += robust * white.transpose() * r;
  }
}

Eigen::VectorXd Refiner::Impl::posterior_sigma() const {
  Eigen::MatrixXd information;
  normal_equations(&information, nullptr);
  const Eigen::LDLT<Eigen::MatrixXd> factor(information);
  const Eigen::Index size = information.rows();
  const Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(size, size));
  return covariance.diagonal().head(scene.num_controls()).cwiseMax(0.0).cwiseSqrt();
}

std::array<double, kNumContours> Refiner::Impl::residuals_mm() const {
  std::array<double, kNumContours> result{};
  for (int c = 0; c < kNumContours; ++c) {
    if (scene.frame.sigma_mm[static_cast<std::size_t>(c)] <= 0.0) continue;
    double sum = 0.0;
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      sum += scene.misfit(k, x.data(), nullptr).squaredNorm();
    }
    result[static_cast<std::size_t>(c)] = std::sqrt(sum / num_nodes(c));
  }
  return result;
}

void RefineOptions::check() const {
  const auto within = [](const char* name, double value, double low, double high) {
    require(value >= low && value <= high,
            std::string(name) + " is " + std::to_string(value) + "; expected a value in [" +
                std::to_string(low) + ", " + std::to_string(high) + "]");
  };
  within("outlier_sigmas", outlier_sigmas, 1.0, 100.0);
  within("ridge_sigma", ridge_sigma, 0.05, 100.0);
  within("antagonist_sigma", antagonist_sigma, 0.01, 100.0);
  within("head_scale_sigma", head_scale_sigma, 1e-4, 1.0);
  within("head_shift_sigma_mm", head_shift_sigma_mm, 0.01, 100.0);
  within("head_turn_sigma_rad", head_turn_sigma_rad, 1e-4, 1.0);
  within("independent_nodes", independent_nodes, 1.0, 9.0);
  within("max_iterations", max_iterations, 1.0, 1000.0);
}

Refiner::Refiner(const FaceResponse& response,
                 const NodeStack& neutral_mm,
                 const RefineOptions& options)
    : impl_(std::make_unique<Impl>()) {
  options.check();
  Scene& scene = impl_->scene;
  scene.response = &response;
  scene.neutral_mm = neutral_mm;
  scene.options = options;
  scene.antagonists = antagonists_of(response.muscles);
  for (int c = 0; c < kNumContours; ++c) {
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      const auto node = static_cast<std::size_t>(k);
      const Point2 along = tangent_at(neutral_mm, c, k);
      const bool is_end = k == first_node(c) || k == last_node(c);
      const double slide = is_end ? slide_of(c).end : slide_of(c).inside;
      scene.unit_whitening[node].row(0) = Point2(-along.y(), along.x()).transpose();
      scene.unit_whitening[node].row(1) = along.transpose() / slide;
      scene.turn[node].col(0) = response.yaw_motion(k);
      scene.turn[node].col(1) = response.pitch_motion(k);
    }
  }
  impl_->pose_problem();
}

Refiner::~Refiner() = default;

RefinedFrame Refiner::refine(const FrameObservation& frame,
                             const Eigen::VectorXd& start,
                             const ControlPrior& time) {
  Impl& impl = *impl_;
  const int n = impl.scene.num_controls();
  impl.load(frame, time);
  std::fill(impl.x.begin(), impl.x.end(), 0.0);
  for (int i = 0; i < n; ++i) {
    impl.x[static_cast<std::size_t>(i)] = std::clamp(start[i], 0.0, 1.0);
  }
  impl.solve();

  RefinedFrame result;
  result.converged = impl.converged;
  result.iterations = impl.iterations;
  const double* h = impl.x.data() + n;
  result.controls = Eigen::Map<const Eigen::VectorXd>(impl.x.data(), n);
  result.head.a = 1.0 + h[0];
  result.head.b = h[1];
  result.head.shift = {h[2], h[3]};
  result.turn_rad = {h[4], h[5]};
  result.sigma = impl.posterior_sigma();
  result.residual_mm = impl.residuals_mm();
  return result;
}

}  // namespace zygoma
