// Corrections by hand: the forces f_i^u of the mouse on a contour (paper, section 6), recorded as
// events and replayed on the automatic track.
//
//   spring    f = k w_i (m - x_i) on the node next to s and its neighbours, w a hat along the
//   contour pin       a spring that stays: at the same place of the face in the frames around
//   volcano   f = k d / |d|^2 away from a centre, even closer than a pixel, zero beyond its radius
//
// (Kass, Witkin & Terzopoulos 1987.) Springs go into the matrix of the snake's step, so any
// strength is stable; a volcano is part of the image landscape.
//
// A correction is not a displacement: it decides which edge the contour lies on. In its own frame
// the snake relaxes under image and mouse. From there the difference to the automatic track is
// taken along, forwards and backwards, as a start only, and every frame relaxes to its own edges.
// The influence ends where the contour falls back onto the automatic track for some frames, at the
// next correction of the same contour (between two, both are blended by time), or out of reach. All
// other frames keep their bits. So the result depends on picture, track and events alone: replay is
// exact, and taking an event away undoes it.
#pragma once

#include <string>
#include <vector>

#include "tracker/evidence.h"
#include "tracker/face_chart.h"

namespace zygoma {

enum class MouseForce { kSpring, kPin, kVolcano };

struct Correction {
  int id = 0;
  int frame = 0;
  std::string contour;  // one of kFeatureSchema
  MouseForce force = MouseForce::kSpring;
  double along = 0.0;  // s, of a spring or pin: where it holds the contour, share of arc length
  Point2 at_px = Point2::Zero();  // the mouse, or the centre of the volcano
  // k, > 0, against image forces of about one; of a volcano times a chart pixel (1/64 of the
  // distance between the eyes).
  double stiffness = 8.0;
  // Spring and pin: share of the arc length that feels it on either side, (0, 1]. Volcano: px.
  double radius = 0.15;

  // Throws InputError naming the first value outside its range.
  void check() const;
};

struct FrameRange {
  int first = 0;
  int last = 0;  // included
};

// What one correction can reach: frames to either side of its own.
inline constexpr int kCorrectionReach = 90;

// Ranges of frames that the corrections can reach in a track of num_frames, joined where they
// overlap, in order of time. Throws InputError naming the correction whose frame is not in it.
std::vector<FrameRange> reach_of(const std::vector<Correction>& corrections, int num_frames);

// Applies the corrections whose frames lie in `range` to `track`, the whole automatic track.
// charts[k] is the chart of frame range.first + k at the head's place there; one without a picture
// means that there is no face, and ends the influence. Returns how many contours changed. The lip
// map is that of the tracker that made the track.
int apply_corrections(const std::vector<Correction>& corrections,
                      const FrameRange& range,
                      const std::vector<FaceChart>& charts,
                      const LipMap& lips,
                      std::vector<ContourSet>& track);

}  // namespace zygoma
