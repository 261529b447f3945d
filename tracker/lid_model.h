// The upper eyelid as an arc between the corners of the eye.
//
// A blink takes two or three frames each way: flow loses the lashes, and a snake left at the open
// lid finds the crease. But the corners of the eye do not move with expression, so the margin of
// the lid is known up to its height: nodes at t in [0, 1] from the inner to the outer corner,
//   corner_in + t (corner_out - corner_in) - (0, 4 t (1 - t) rise),
// and the height is searched afresh in every frame, over everything between a shut and a startled
// eye, for the edge where skin gives way to lashes: brightness falls downwards.
#pragma once

#include <vector>

#include "tracker/evidence.h"
#include "tracker/head_pose.h"

namespace zygoma {

struct Lid {
  // Chart px, seen straight on.
  Point2 inner = Point2::Zero();
  Point2 outer = Point2::Zero();
  double rise = 0.0;       // of the middle above the corners, eye distances; negative when shut
  double open_rise = 0.1;  // at the start
};

std::vector<Point2> lid_nodes(const Lid& lid, const HeadTurn& turn = {});

Lid usual_lid(bool left);
// Without history: place of the corners and height together.
Lid find_lid(const Evidence& evidence, bool left);
// With history: the height alone.
Lid follow_lid(const Evidence& evidence, const Lid& last, const HeadTurn& turn);

}  // namespace zygoma
