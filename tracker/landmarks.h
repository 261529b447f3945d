// The 68 landmarks that most face trackers speak (iBUG order), as eyes and as contours.
//
//   0-16 jaw, the subject's right to left   17-21 right brow, outer to inner   22-26 left brow,
//   inner to outer   27-30 bridge of the nose, 31-35 its base   36-41 right eye, 42-47 left eye
//   48-59 outer lips, from the right corner over the upper lip   60-67 inner lips
//
// Brows are marked along their upper edges, lips along their outer borders and upper lids along
// their margins, as our contours are.
// The boss of the chin is not marked; it lies between the lower lip and the tip of the chin (8).
// Nothing marks furrows and hairline.
#pragma once

#include <array>

#include "tracker/contour_set.h"

namespace zygoma {

inline constexpr size_t kNumLandmarks = 68;
using Landmarks = std::array<Point2, kNumLandmarks>;  // px of the picture

// Where the boss of the chin lies between the middle of the lower lip (0) and the tip of the chin.
inline constexpr double kChinBossShare = 0.83;

// Centres of the eyes, the subject's sides.
Point2 right_eye_of(const Landmarks& landmarks);
Point2 left_eye_of(const Landmarks& landmarks);

// The contours that the landmarks mark, in the order of the schema and with its numbers of nodes;
// the others are lost.
ContourSet contours_from_landmarks(const Landmarks& landmarks);

}  // namespace zygoma
