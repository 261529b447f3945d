// The paper's closed-form estimates (section 6c, P-66 to P-72): each control is read from one
// point.
//
//   control                                   read from
//   zygomaticus major                         the ends of the upper lip
//   levator labii superioris alaeque nasi     the uppermost point of the nasolabial furrow
//   occipitofrontalis inner / major / outer   the inner / centre / outer point of the brow
//   jaw                                       the mean of the chin boss
//
// The paper gives no formula for the conversion; ours is, for a reading point with displacement d
// from the neutral in the head frame and the model's full motion m of that point,
//
//   c = clamp(d . m / ||m||^2, 0, 1).
//
// The jaw is read first and its own motion of the other points taken off, as an open mouth carries
// its corners with it.
#pragma once

#include <Eigen/Core>

#include "retarget/response.h"

namespace zygoma {

// Displacements of a frame from the neutral, mm of the model, head motion taken off.
struct Displacements {
  NodeStack mm = NodeStack::Zero();
  std::array<bool, kNumContours> usable{};  // seen well enough to drive something
};

// Controls (muscles, then jaw) in [0, 1]; 0 for those the paper does not estimate and for those
// whose contour is not usable. `fallback` (same size) replaces the latter where it is given.
Eigen::VectorXd estimate_controls(const Displacements& observed,
                                  const FaceResponse& response,
                                  const Eigen::VectorXd* fallback = nullptr);

}  // namespace zygoma
