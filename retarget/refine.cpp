#include "retarget/refine.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
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
      put(i, i, (x[i] + options.rest_pull) / options.ridge_sigma, 1.0 / options.ridge_sigma);
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

// Cauchy's loss as a residual: the vector r shrunk to the length sqrt(rho(r.r)), so that its square
// is the loss exactly, and its derivative.
void shrink_outlier(double width, Eigen::Vector2d& r, Eigen::Matrix<double, 2, Eigen::Dynamic>* j) {
  const double square = width * width;
  const double s = r.squaredNorm();
  const double ratio = s / square;
  // g = sqrt(rho / s), rho = square log(1 + ratio); its series near zero.
  const bool tiny = ratio < 1e-6;
  const double g = tiny ? 1.0 - 0.25 * ratio : std::sqrt(std::log1p(ratio) / ratio);
  if (j != nullptr) {
    const double slope = tiny ? -0.25 / square : 0.5 * (1.0 / (1.0 + ratio) - g * g) / (g * s);
    const Eigen::Matrix2d turn = g * Eigen::Matrix2d::Identity() + 2.0 * slope * r * r.transpose();
    *j = (turn * *j).eval();
  }
  r *= g;
}

// All residuals of a frame in one block; only the free ones of the parameters are Ceres' business.
class FrameCost final : public ceres::CostFunction {
 public:
  FrameCost(const Scene& scene, const std::vector<double>& x, const std::vector<int>& free)
      : scene_(scene), x_(x), free_(free) {
    set_num_residuals(2 * kNumNodes + scene.num_priors());
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    std::vector<double> x = x_;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      x[static_cast<std::size_t>(free_[i])] = values[0][i];
    }
    double* jacobian = jacobians == nullptr ? nullptr : jacobians[0];
    evaluate_nodes(x.data(), residuals, jacobian);
    RowMajor slope;
    scene_.priors(x.data(), residuals + 2 * kNumNodes, jacobian == nullptr ? nullptr : &slope);
    if (jacobian == nullptr) return true;
    Eigen::Map<RowMajor> all(jacobian, num_residuals(), static_cast<Eigen::Index>(free_.size()));
    for (std::size_t i = 0; i < free_.size(); ++i) {
      all.col(static_cast<Eigen::Index>(i)).tail(scene_.num_priors()) = slope.col(free_[i]);
    }
    return true;
  }

 private:
  void evaluate_nodes(const double* x, double* residuals, double* jacobian) const {
    const auto num_free = static_cast<Eigen::Index>(free_.size());
    Eigen::Map<RowMajor> all(jacobian, jacobian == nullptr ? 0 : num_residuals(), num_free);
    Eigen::Matrix<double, 2, Eigen::Dynamic> full(2, scene_.num_parameters());
    Eigen::Matrix<double, 2, Eigen::Dynamic> slope(2, num_free);
    for (int k = 0; k < kNumNodes; ++k) {
      Eigen::Map<Eigen::Vector2d> out(residuals + 2 * k);
      if (scene_.inverse_sigma[static_cast<std::size_t>(k)] <= 0.0) {
        out.setZero();
        if (jacobian != nullptr) all.middleRows(2 * k, 2).setZero();
        continue;
      }
      const Eigen::Matrix2d whitening = scene_.whitening(k);
      Eigen::Vector2d r = whitening * scene_.misfit(k, x, jacobian == nullptr ? nullptr : &full);
      if (jacobian != nullptr) {
        for (Eigen::Index i = 0; i < num_free; ++i) {
          slope.col(i) = whitening * full.col(free_[static_cast<std::size_t>(i)]);
        }
      }
      shrink_outlier(scene_.options.outlier_sigmas, r, jacobian == nullptr ? nullptr : &slope);
      out = r;
      if (jacobian != nullptr) all.middleRows(2 * k, 2) = slope;
    }
  }

  const Scene& scene_;
  const std::vector<double>& x_;
  const std::vector<int>& free_;
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
  std::vector<double> x;
  bool converged = false;
  int iterations = 0;

  void load(const FrameObservation& frame, const ControlPrior& time);
  void solve();
  bool solve_free(const std::vector<int>& held);
  std::vector<int> pushed_outwards() const;
  void normal_equations(Eigen::MatrixXd* information, Eigen::VectorXd* gradient) const;
  Eigen::VectorXd posterior_sigma() const;
  std::array<double, kNumContours> residuals_mm() const;
};

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
  converged = false;
  iterations = 0;
  std::vector<int> held = pushed_outwards();
  for (int round = 0; round < kMostRounds; ++round) {
    const bool settled = solve_free(held);
    std::vector<int> next = pushed_outwards();
    converged = settled && next == held;
    if (converged || iterations >= scene.options.max_iterations) break;
    held = std::move(next);
  }
}

// One bounded solve over the parameters that are not held; true when it converged.
bool Refiner::Impl::solve_free(const std::vector<int>& held) {
  std::vector<int> free;
  for (int i = 0; i < scene.num_parameters(); ++i) {
    if (!std::binary_search(held.begin(), held.end(), i)) free.push_back(i);
  }
  std::vector<double> values;
  for (const int i : free) values.push_back(x[static_cast<std::size_t>(i)]);

  FrameCost cost(scene, x, free);
  ceres::Problem::Options ours;
  ours.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ours.disable_all_safety_checks = true;
  ceres::Problem problem(ours);
  problem.AddResidualBlock(&cost, nullptr, values.data());
  for (std::size_t i = 0; i < free.size() && free[i] < scene.num_controls(); ++i) {
    problem.SetParameterLowerBound(values.data(), static_cast<int>(i), 0.0);
    problem.SetParameterUpperBound(values.data(), static_cast<int>(i), 1.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  // Steps that run into a new bound creep; look at the held set again before they cost much.
  options.max_num_iterations = std::min(6, scene.options.max_iterations - iterations);
  options.function_tolerance = 1e-4;
  options.parameter_tolerance = 1e-4;
  options.gradient_tolerance = 1e-8;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e6;  // nearly linear: trust Gauss-Newton from the start
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  iterations += static_cast<int>(summary.iterations.size());
  for (std::size_t i = 0; i < free.size(); ++i) x[static_cast<std::size_t>(free[i])] = values[i];
  return summary.termination_type == ceres::CONVERGENCE;
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
  within("rest_pull", rest_pull, 0.0, 1.0);
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
  impl_->x.assign(static_cast<std::size_t>(scene.num_parameters()), 0.0);
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
