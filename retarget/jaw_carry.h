// How far a performer's jaw takes the corners of the mouth along, as a multiple of the model's.
//
// No two faces move alike, and here they differ most: one jaw takes the corners down by more than
// half as far as the chin, another by a quarter. From frame to frame that is noise, over a clip it
// is always the same and can be learned. Left unlearned, the muscles that lift the corners are read
// from every mouth that merely opens.
//
// With the carry q, the jaw's motion of the node k of the lips is multiplied by 1 + (q - 1) w_k,
// w_k = 1 at the corners and 0 in the middle. It is found with the unknowns x (controls and head)
// of single frames eliminated: with the derivatives J by x and b by q of the residuals r at their
// solution, priors of x included, one step of Gauss-Newton on what is left when every frame has
// explained itself as well as it can is
//
//   q -= (g + n (q - 1) / s^2) / (S + n / s^2),
//   S = sum_frames b^T b - b^T J (J^T J)^-1 J^T b,   g = sum_frames b^T r.
//
// where n frames carry the evidence of one, as what else is unlike about a face is so in all of
// them. Controls at a bound stay there, which is why a second step is worth taking: a smile that
// was only read into the jaw has come to rest by then. s is the share by which two faces are
// thought to move unlike (RefineOptions::relative_error): a clip that says little changes little.
#pragma once

#include <span>

#include "retarget/frame_system.h"
#include "retarget/refine.h"

namespace zygoma {

inline constexpr double kLeastJawCarry = 0.0;
inline constexpr double kLargestJawCarry = 1.5;

FaceResponse with_jaw_carry(const FaceResponse& model, double carry);

// One step from `carry`, with which the frames were solved, each without time; `scene` has the
// response of that carry.
double learn_jaw_carry(const FaceResponse& model,
                       double carry,
                       FrameScene& scene,
                       std::span<const FrameObservation> frames,
                       std::span<const RefinedFrame> solved);

}  // namespace zygoma
