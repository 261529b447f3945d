#include "retarget/jaw_carry.h"

#include <algorithm>
#include <cassert>
#include <vector>

namespace zygoma {
namespace {

// A face is unlike the model in the same ways in all frames of a clip: so many carry the evidence
// of one.
constexpr double kFramesAsOne = 4.0;

// The weights w of the header, for both axes of every node.
Eigen::VectorXd share_of_corner(const FaceResponse& face) {
  Eigen::VectorXd share = Eigen::VectorXd::Zero(2 * kNumNodes);
  const double right_mm = face.rest_mm(0, first_node(kUpperLipContour));
  const double left_mm = face.rest_mm(0, last_node(kUpperLipContour));
  if (!(left_mm > right_mm)) return share;
  for (const int contour : {kUpperLipContour, kLowerLipContour}) {
    for (int k = first_node(contour); k <= last_node(contour); ++k) {
      const double across = (2.0 * face.rest_mm(0, k) - right_mm - left_mm) / (left_mm - right_mm);
      share.segment<2>(2 * k).setConstant(std::min(1.0, across * across));
    }
  }
  return share;
}

// Of the unknowns of a frame, those that are not held at a bound.
std::vector<Eigen::Index> free_unknowns(const Eigen::VectorXd& controls, int num_unknowns) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < num_unknowns; ++i) {
    if (i >= controls.size() || (controls[i] > 0.0 && controls[i] < 1.0)) free.push_back(i);
  }
  return free;
}

}  // namespace

FaceResponse with_jaw_carry(const FaceResponse& model, double carry) {
  FaceResponse result = model;
  const Eigen::ArrayXd factor = 1.0 + (carry - 1.0) * share_of_corner(model).array();
  for (Eigen::MatrixXd* part : {&result.linear_mm, &result.quadratic_mm, &result.cubic_mm}) {
    part->rightCols<1>().array() *= factor;
  }
  return result;
}

double learn_jaw_carry(const FaceResponse& model,
                       double carry,
                       FrameScene& scene,
                       std::span<const FrameObservation> frames,
                       std::span<const RefinedFrame> solved) {
  assert(frames.size() == solved.size());
  const double sigma = scene.options.relative_error;
  if (!(sigma > 0.0)) return carry;
  const Eigen::VectorXd share = share_of_corner(model);
  const Eigen::Index jaw = scene.num_controls() - 1;
  double information = kFramesAsOne / (sigma * sigma);
  double gradient = kFramesAsOne * (carry - 1.0) / (sigma * sigma);
  NormalEquations equations;
  Eigen::VectorXd by_jaw;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    const Eigen::VectorXd& controls = solved[t].controls;
    if (controls[jaw] <= 0.0) continue;
    const FrameSystem system(scene, frames[t]);
    system.normal_equations(controls, solved[t].head, true, equations);
    const Eigen::Index rows = system.num_rows();

    Eigen::VectorXd jaw_alone = Eigen::VectorXd::Zero(controls.size());
    jaw_alone[jaw] = controls[jaw];
    model.displace(jaw_alone, by_jaw);
    Eigen::MatrixXd by_carry(rows, 1);
    system.rows_along(by_jaw.cwiseProduct(share), by_carry);

    const std::vector<Eigen::Index> free = free_unknowns(controls, scene.num_unknowns());
    const Eigen::VectorXd all = scene.jacobian.topRows(rows).transpose() * by_carry;
    const Eigen::VectorXd shared = all(free);
    const Eigen::MatrixXd own = equations.information(free, free);
    information += by_carry.squaredNorm() - shared.dot(own.ldlt().solve(shared));
    gradient += by_carry.col(0).dot(scene.residual.head(rows));
  }
  return std::clamp(carry - gradient / information, kLeastJawCarry, kLargestJawCarry);
}

}  // namespace zygoma
