// How the head is turned: yaw and pitch beside the similarity, from the parallax of rigid points.
//
// A turned head moves the nose against the eyes. A similarity fitted to both follows neither, and
// what it leaves over looks like motion of brows and mouth: at 20 degrees a tenth of the eye
// distance. So each rigid point has a depth z (of a usual face, towards the camera, from the plane
// of the eyes), and with p = (x, y) from the middle of the eyes the face is seen at
//   S( x cos(yaw) + z sin(yaw),  y cos(pitch) - (z cos(yaw) - x sin(yaw)) sin(pitch) ),
// weak perspective. S, yaw and pitch are fitted together (Gauss-Newton, Tukey's weights, a weak
// prior on no turn). The chart keeps following S alone: the eyes stay where they are, and turned
// parts are known to be displaced.
#pragma once

#include <vector>

#include "tracker/head_frame.h"

namespace zygoma {

// Positive yaw: the nose goes to the right of the picture; positive pitch: it goes up.
struct HeadTurn {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;

  // A chart point of the face seen straight on, of the given depth (chart px), as it is seen now.
  Point2 apply(const Point2& straight, double depth) const;
};

// A point that does not move with expression; chart px, seen straight on.
struct RigidPoint {
  Point2 position = Point2::Zero();
  double depth = 0.0;
};

struct HeadPoseFit {
  Similarity similarity;
  HeadTurn turn;
  double inlier_share = 0.0;  // of the points given
  bool ok = false;            // as HeadFrameFit
};

// Fits S after turn to `points` seen at `to`; `last` is a turn to start from.
HeadPoseFit fit_head_pose(const std::vector<RigidPoint>& points,
                          const std::vector<Point2>& to,
                          const HeadTurn& last);

}  // namespace zygoma
