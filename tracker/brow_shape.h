// A brow moves as a strip of skin: it rises, tilts and bends, but hardly slides along itself.
//
// The upper edge of a brow says where it is across, not along; nodes that follow flow and edge
// drift towards one end, and with them the inner, middle and outer points from which the muscles
// are read. So after relaxing, the contour is read as a motion of its first shape: a shift along x
// of which only a share is believed, and a rise that is quadratic along the brow,
//   rise(t) = c_0 + c_1 t + c_2 t^2,  t in [-1, 1],
// fitted to the relaxed nodes by least squares with a small ridge on tilt and bend.
#pragma once

#include <vector>

#include "tracker/contour_set.h"

namespace zygoma {

// `relaxed` on the motions of `at_start` (same number of nodes); `slide_px` is how far flow says
// the brow went along x. Chart px.
std::vector<Point2> as_brow_motion(const std::vector<Point2>& relaxed,
                                   const std::vector<Point2>& at_start,
                                   double slide_px);

}  // namespace zygoma
