// One frame as a least-squares problem in the controls u and the head h (refine.h has the formula),
// and its normal equations: the information J^T J, the gradient J^T r, the cost r^T r.
//
// A frame has some two hundred residuals but only 25 unknowns, and a solver of least squares asks
// for nothing but those three. So they are summed here once, and the solver is handed residuals of
// the size of the unknowns that have the same three (reduce()): with J^T J = R^T R they are
//
//   ( R^-T J^T r ; sqrt(r^T r - ||R^-T J^T r||^2) ),  derivative ( R ; 0 ).
//
// Every step of Gauss-Newton or Levenberg-Marquardt is the same, at a tenth of the work.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "retarget/head_view.h"
#include "retarget/response.h"

namespace zygoma {

struct RefineOptions {
  double outlier_sigmas = 3.0;       // [1, 1e6]; small: strong expressions fade as outliers; large:
                                     // plain least squares
  double ridge_sigma = 0.8;          // [0.05, 1e6]; small: everything shrinks towards rest
  double rest_pull = 0.15;           // [0, 1]; the ridge is centred this far below 0, so that small
                                     // contractions need evidence; large: weak expressions are lost
  double antagonist_sigma = 0.15;    // [0.01, 1e6]; small: raisers and lowerers exclude each other
                                     // even where the performer uses both
  double tie_sigma = 0.4;            // [0.01, 1e6]; of the middle frontalis to the inner one
  double head_scale_sigma = 0.05;    // also of the roll, in rad; [1e-4, 10]
  double head_shift_sigma_mm = 5.0;  // [0.01, 1000]
  double head_turn_sigma_rad = 0.06;  // yaw and pitch; [1e-4, 10]; large: turns explain expressions
  double relative_error = 0.25;       // [0, 10]; share by which one person's skin moves unlike
                                      // another's; small: large motions of skin the model does
                                      // not have pull at everything else
  double independent_nodes = 6.0;     // how many of a contour's nodes err independently; [1, 100]
  double fastest_per_s = 6.0;         // change of a contraction, one sigma; [0.1, 1e9]
  double acceleration_per_s2 = 60.0;  // in windows; [1, 1e9]
  double turn_acceleration_per_s2 = 4.0;  // of yaw and pitch, rad; [0.01, 1e9]
  int window_frames = 40;                 // solved together and kept; [1, 1000]
  int lookahead_frames = 8;  // solved with them and solved again in the next; [0, 1000]
  double tolerance = 1e-4;   // relative change of cost or controls that ends it, [1e-15, 0.1]
  int max_iterations = 40;   // over all rounds of the active set; [1, 1000]

  void check() const;
};

// What a better model of the face adds to the response around `at`:
// offset + slope (u - at). An empty slope is zero.
struct ModelCorrection {
  Eigen::VectorXd at;
  Eigen::VectorXd offset_mm;
  Eigen::MatrixXd slope_mm;
};

struct FrameObservation {
  double time_s = 0.0;
  NodeStack mm = NodeStack::Zero();
  std::array<double, kNumContours> sigma_mm{};  // 0: the contour is not used
  const ModelCorrection* correction = nullptr;
};

// Gaussian belief about the controls from the instant before; an infinite sigma says nothing.
struct ControlPrior {
  Eigen::VectorXd mean;
  double sigma = std::numeric_limits<double>::infinity();
};

// In the unknowns (u, h).
struct NormalEquations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double cost = 0.0;
};

// How much quicker than fastest_per_s and acceleration_per_s2 each control moves: a lid closes and
// opens again while a brow only sets out.
Eigen::VectorXd agility_of(const FaceResponse& response);

// What all frames share, and the workspace of one evaluation.
class FrameScene {
 public:
  // `response` is referred to, not copied.
  FrameScene(const FaceResponse& response,
             const NodeStack& neutral_mm,
             double inverse_distance_per_mm,
             const RefineOptions& options);

  const FaceResponse& response;
  const NodeStack neutral_mm;
  const double inverse_distance_per_mm;
  const RefineOptions options;
  std::vector<std::pair<int, int>> antagonists;
  std::vector<std::pair<int, int>> tied;
  const Eigen::VectorXd agility;
  const bool lids_move;  // of the face; else only the corners of the eyes are used

  int num_controls() const { return response.num_controls(); }
  int num_unknowns() const { return num_controls() + HeadView::kNumParameters; }

  // Whitened residuals of the used nodes and their derivative by the unknowns, after
  // FrameSystem::linearise(); the first rows of it.
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd displacement;
  Eigen::MatrixXd slope;
  std::array<Eigen::Matrix2d, kNumNodes> by_place;  // residual of a used node by where it is
};

class FrameSystem {
 public:
  using Head = HeadView::Parameters;

  // Refers to both.
  FrameSystem(FrameScene& scene, const FrameObservation& observation);

  void lean_on(const ControlPrior& before) { time_ = before; }

  double cost(const Eigen::VectorXd& u, const Head& head) const;
  // With the information or the gradient alone, where that is all one wants.
  void normal_equations(const Eigen::VectorXd& u,
                        const Head& head,
                        bool with_information,
                        NormalEquations& result) const;
  // Of everything but the nodes.
  void add_priors(const Eigen::VectorXd& u, const Head& head, NormalEquations& result) const;

  // Fills the scene's residual and jacobian; returns how many rows of them count.
  Eigen::Index linearise(const Eigen::VectorXd& u, const Head& head) const;
  // Derivative of these rows when all nodes move along the columns of `motions` (2 node + axis),
  // after linearise().
  void rows_along(const Eigen::MatrixXd& motions, Eigen::Ref<Eigen::MatrixXd> rows) const;
  Eigen::Index num_rows() const { return static_cast<Eigen::Index>(2 * used_.size()); }
  // Rows of a contour among these: {first, number}.
  std::pair<Eigen::Index, Eigen::Index> rows_of(int contour) const;
  // RMS of the unweighted misfit of a contour, mm, after linearise() or cost().
  double misfit_mm(int contour, const Head& head) const;

 private:
  struct UsedNode {
    int node;
    Eigen::Matrix2d whitening;
  };
  struct NodeTerm {
    HeadView::Sight sight;
    Point2 misfit_mm;
    Eigen::Vector2d residual;
    Eigen::Matrix2d weight;  // of derivatives of the misfit
  };

  void whiten(int contour);
  void displace(const Eigen::VectorXd& u, bool with_slope) const;
  NodeTerm term_of(const UsedNode& used, const HeadView& view) const;

  FrameScene& scene_;
  const FrameObservation& frame_;
  ControlPrior time_;
  std::vector<UsedNode> used_;  // in the order of the nodes
  std::array<int, kNumContours + 1> used_begin_{};
};

// Residuals of the size of the unknowns, and one, with these normal equations; the derivative is
// `root` with a row of zeros below. `workspace` is that of the factor.
void reduce(const NormalEquations& equations,
            Eigen::LDLT<Eigen::MatrixXd>& workspace,
            Eigen::VectorXd& residual,
            Eigen::MatrixXd& root);

}  // namespace zygoma
