#include "retarget/frame_system.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "src/base/check.h"
#include "src/base/names.h"

namespace zygoma {
namespace {

constexpr int kNumHead = HeadView::kNumParameters;

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
  std::vector<std::pair<int, int>> result;
  for (const auto& [first, second] : pairs) {
    for (const char* side : {"_L", "_R"}) {
      const int a = find_name(muscles, std::string(first) + side);
      const int b = find_name(muscles, std::string(second) + side);
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

std::array<double, kNumHead> head_sigmas(const RefineOptions& options) {
  return {options.head_scale_sigma,
          options.head_scale_sigma,
          options.head_shift_sigma_mm,
          options.head_shift_sigma_mm,
          options.head_turn_sigma_rad,
          options.head_turn_sigma_rad};
}

}  // namespace

void RefineOptions::check() const {
  require_range("outlier_sigmas", outlier_sigmas, 1.0, 1e6);
  require_range("ridge_sigma", ridge_sigma, 0.05, 1e6);
  require_range("rest_pull", rest_pull, 0.0, 1.0);
  require_range("antagonist_sigma", antagonist_sigma, 0.01, 1e6);
  require_range("tie_sigma", tie_sigma, 0.01, 1e6);
  require_range("head_scale_sigma", head_scale_sigma, 1e-4, 10.0);
  require_range("head_shift_sigma_mm", head_shift_sigma_mm, 0.01, 1000.0);
  require_range("head_turn_sigma_rad", head_turn_sigma_rad, 1e-4, 10.0);
  require_range("relative_error", relative_error, 0.0, 10.0);
  require_range("independent_nodes", independent_nodes, 1.0, 100.0);
  require_range("fastest_per_s", fastest_per_s, 0.1, 1e9);
  require_range("acceleration_per_s2", acceleration_per_s2, 1.0, 1e9);
  require_range("turn_acceleration_per_s2", turn_acceleration_per_s2, 0.01, 1e9);
  require_range("window_frames", window_frames, 1.0, 1000.0);
  require_range("lookahead_frames", lookahead_frames, 0.0, 1000.0);
  require_range("tolerance", tolerance, 1e-15, 0.1);
  require_range("max_iterations", max_iterations, 1.0, 1000.0);
}

Eigen::VectorXd agility_of(const FaceResponse& response) {
  constexpr double kLid = 10.0;
  Eigen::VectorXd agility = Eigen::VectorXd::Ones(response.num_controls());
  for (int i = 0; i < response.num_muscles(); ++i) {
    if (moves_lid(response.muscles[static_cast<std::size_t>(i)])) agility[i] = kLid;
  }
  return agility;
}

FrameScene::FrameScene(const FaceResponse& face,
                       const NodeStack& neutral,
                       double inverse_distance,
                       const RefineOptions& chosen)
    : response(face),
      neutral_mm(neutral),
      inverse_distance_per_mm(inverse_distance),
      options(chosen),
      antagonists(indices_of({{"occipitofrontalis_inner", "corrugator_supercilii"},
                              {"occipitofrontalis_major", "corrugator_supercilii"},
                              {"zygomaticus_major", "depressor_anguli_oris"},
                              {"levator_labii_superioris", "depressor_labii_inferioris"},
                              {"levator_palpebrae_superioris", "orbicularis_oculi_palpebral"}},
                             face.muscles)),
      tied(indices_of({{"occipitofrontalis_major", "occipitofrontalis_inner"}}, face.muscles)),
      agility(agility_of(face)),
      lids_move(std::any_of(face.muscles.begin(), face.muscles.end(), moves_lid)),
      residual(2 * kNumNodes),
      jacobian(2 * kNumNodes, face.num_controls() + kNumHead) {}

FrameSystem::FrameSystem(FrameScene& scene, const FrameObservation& observation)
    : scene_(scene), frame_(observation) {
  used_.reserve(kNumNodes);
  for (int c = 0; c < kNumContours; ++c) {
    used_begin_[static_cast<std::size_t>(c)] = static_cast<int>(used_.size());
    whiten(c);
  }
  used_begin_.back() = static_cast<int>(used_.size());
}

void FrameSystem::whiten(int contour) {
  const auto index = static_cast<std::size_t>(contour);
  const bool seen =
      frame_.sigma_mm[index] > 0.0 && (scene_.response.has_contour[index] || is_eyelid(contour));
  if (!seen) return;
  // Nodes of one contour err together: n nodes carry the evidence of a few.
  const double together =
      is_eyelid(contour)
          ? 1.0
          : std::sqrt(std::max(1.0, num_nodes(contour) / scene_.options.independent_nodes));
  for (int k = first_node(contour); k <= last_node(contour); ++k) {
    const bool is_end = k == first_node(contour) || k == last_node(contour);
    // The corners of an eye are fixed to the skull; what is between them moves by its own muscles.
    if (is_eyelid(contour) && !is_end &&
        !(scene_.lids_move && scene_.response.has_contour[index])) {
      continue;
    }
    const double gone = (frame_.mm.col(k) - scene_.neutral_mm.col(k)).norm();
    const double sigma =
        std::hypot(frame_.sigma_mm[index], scene_.options.relative_error * gone) * together;
    const Point2 along = tangent_at(frame_.mm, contour, k);
    const double slide = is_end ? slide_of(contour).end : slide_of(contour).inside;
    UsedNode node{k, {}};
    node.whitening.row(0) = Point2(-along.y(), along.x()).transpose() / sigma;
    node.whitening.row(1) = along.transpose() / (slide * sigma);
    used_.push_back(node);
  }
}

// The response, corrected; in the scene's workspace.
void FrameSystem::displace(const Eigen::VectorXd& u, bool with_slope) const {
  scene_.response.displace(u, scene_.displacement, with_slope ? &scene_.slope : nullptr);
  if (frame_.correction == nullptr) return;
  const ModelCorrection& more = *frame_.correction;
  scene_.displacement += more.offset_mm;
  if (more.slope_mm.size() == 0) return;
  scene_.displacement.noalias() += more.slope_mm * (u - more.at);
  if (with_slope) scene_.slope += more.slope_mm;
}

// Neutral, moved, seen, compared, whitened, and robust: after displace().
FrameSystem::NodeTerm FrameSystem::term_of(const UsedNode& used, const HeadView& view) const {
  const Point2 place =
      scene_.neutral_mm.col(used.node) + scene_.displacement.segment<2>(2 * used.node);
  NodeTerm term{view.see(place, scene_.response.rest_depth_mm[used.node]), {}, {}, {}};
  term.misfit_mm = term.sight.at - frame_.mm.col(used.node);
  term.residual = used.whitening * term.misfit_mm;
  term.weight = shrink_outlier(scene_.options.outlier_sigmas, term.residual) * used.whitening;
  return term;
}

double FrameSystem::cost(const Eigen::VectorXd& u, const Head& head) const {
  displace(u, false);
  const HeadView view(head, scene_.inverse_distance_per_mm);
  NormalEquations result;
  for (const UsedNode& used : used_) result.cost += term_of(used, view).residual.squaredNorm();
  add_priors(u, head, result);
  return result.cost;
}

Eigen::Index FrameSystem::linearise(const Eigen::VectorXd& u, const Head& head) const {
  displace(u, true);
  const HeadView view(head, scene_.inverse_distance_per_mm);
  const Eigen::Index n = scene_.num_controls();
  for (std::size_t k = 0; k < used_.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(2 * k);
    const NodeTerm term = term_of(used_[k], view);
    scene_.residual.segment<2>(row) = term.residual;
    scene_.jacobian.block<2, kNumHead>(row, n).noalias() = term.weight * term.sight.by_head;
    scene_.by_place[k].noalias() = term.weight * term.sight.by_node;
  }
  rows_along(scene_.slope, scene_.jacobian.leftCols(n));
  return num_rows();
}

void FrameSystem::rows_along(const Eigen::MatrixXd& motions,
                             Eigen::Ref<Eigen::MatrixXd> rows) const {
  for (Eigen::Index i = 0; i < motions.cols(); ++i) {
    const double* from = motions.col(i).data();
    double* to = rows.col(i).data();
    for (std::size_t k = 0; k < used_.size(); ++k, to += 2) {
      const Eigen::Matrix2d& m = scene_.by_place[k];
      const double* s = from + 2 * used_[k].node;
      to[0] = m(0, 0) * s[0] + m(0, 1) * s[1];
      to[1] = m(1, 0) * s[0] + m(1, 1) * s[1];
    }
  }
}

void FrameSystem::normal_equations(const Eigen::VectorXd& u,
                                   const Head& head,
                                   bool with_information,
                                   NormalEquations& result) const {
  const Eigen::Index rows = linearise(u, head);
  const auto j = scene_.jacobian.topRows(rows);
  const auto r = scene_.residual.head(rows);
  const Eigen::Index size = scene_.num_unknowns();
  result.gradient.resize(size);
  result.gradient.noalias() = j.transpose() * r;
  result.cost = r.squaredNorm();
  result.information.resize(with_information ? size : 0, with_information ? size : 0);
  if (with_information) {
    result.information.setZero();
    result.information.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
    result.information.triangularView<Eigen::StrictlyUpper>() = result.information.transpose();
  }
  add_priors(u, head, result);
}

void FrameSystem::add_priors(const Eigen::VectorXd& u,
                             const Head& head,
                             NormalEquations& result) const {
  const RefineOptions& options = scene_.options;
  const Eigen::Index n = scene_.num_controls();
  // One residual of unit variance that depends on up to two unknowns.
  const auto add = [&](double r, Eigen::Index i, double slope_i, Eigen::Index j, double slope_j) {
    result.cost += r * r;
    if (result.gradient.size() > 0) {
      result.gradient[i] += slope_i * r;
      result.gradient[j] += slope_j * r;
    }
    if (result.information.size() == 0) return;
    result.information(i, i) += slope_i * slope_i;
    result.information(j, j) += slope_j * slope_j;
    result.information(i, j) += slope_i * slope_j;
    result.information(j, i) += slope_i * slope_j;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const double ridge = 1.0 / options.ridge_sigma;
    add(ridge * (u[i] + options.rest_pull), i, ridge, i, 0.0);
    if (!std::isfinite(time_.sigma)) continue;
    const double hold = 1.0 / (time_.sigma * scene_.agility[i]);
    add(hold * (u[i] - time_.mean[i]), i, hold, i, 0.0);
  }
  const std::array<double, kNumHead> sigma = head_sigmas(options);
  for (Eigen::Index i = 0; i < kNumHead; ++i) {
    const double weight = 1.0 / sigma[static_cast<std::size_t>(i)];
    add(weight * head[i], n + i, weight, n + i, 0.0);
  }
  for (const auto& [a, b] : scene_.antagonists) {
    const double weight = 1.0 / options.antagonist_sigma;
    add(weight * u[a] * u[b], a, weight * u[b], b, weight * u[a]);
  }
  for (const auto& [a, b] : scene_.tied) {
    const double weight = 1.0 / options.tie_sigma;
    add(weight * (u[a] - u[b]), a, weight, b, -weight);
  }
}

std::pair<Eigen::Index, Eigen::Index> FrameSystem::rows_of(int contour) const {
  const auto c = static_cast<std::size_t>(contour);
  return {2 * used_begin_[c], 2 * (used_begin_[c + 1] - used_begin_[c])};
}

double FrameSystem::misfit_mm(int contour, const Head& head) const {
  const HeadView view(head, scene_.inverse_distance_per_mm);
  const auto c = static_cast<std::size_t>(contour);
  double sum = 0.0;
  for (int k = used_begin_[c]; k < used_begin_[c + 1]; ++k) {
    sum += term_of(used_[static_cast<std::size_t>(k)], view).misfit_mm.squaredNorm();
  }
  const int count = used_begin_[c + 1] - used_begin_[c];
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

void reduce(const NormalEquations& equations,
            Eigen::LDLT<Eigen::MatrixXd>& workspace,
            Eigen::VectorXd& residual,
            Eigen::MatrixXd& root) {
  const Eigen::Index n = equations.gradient.size();
  workspace.compute(equations.information);
  const Eigen::VectorXd scale = workspace.vectorD().cwiseMax(0.0).cwiseSqrt();
  root = workspace.transpositionsP() * Eigen::MatrixXd::Identity(n, n);
  root = workspace.matrixU() * root;
  root = scale.asDiagonal() * root;
  residual.resize(n + 1);
  residual.head(n) = workspace.transpositionsP() * equations.gradient;
  workspace.matrixL().solveInPlace(residual.head(n));
  for (Eigen::Index i = 0; i < n; ++i) residual[i] = scale[i] > 0.0 ? residual[i] / scale[i] : 0.0;
  residual[n] = std::sqrt(std::max(0.0, equations.cost - residual.head(n).squaredNorm()));
}

}  // namespace zygoma
