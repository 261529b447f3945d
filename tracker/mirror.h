// A clip and its mirror image give mirrored tracks, to the bit.
//
// Resampling in fixed point, optical flow, cascades and sums all round a little differently on a
// mirrored picture. So the picture itself says which way round it is looked at: by the sign of
//   M = sum (2 x - (W - 1)) I(x, y)
// over its pixels, an exact integer that changes its sign in the mirror; where it is zero, by the
// first pixel that differs from its twin on the other side. A picture that equals its mirror image
// says nothing; then contours that somebody gave for it are asked, or the next picture. From then
// on the answer stands for the whole track: what goes into the tracker and what comes out is
// turned, and nothing in between knows.
//
// Coordinates are first rounded to 2^-20 px (a head to 2^-32), so that x -> W - 1 - x is exact both
// ways.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "tracker/confidence.h"
#include "tracker/contour_set.h"
#include "tracker/correction.h"
#include "tracker/feature_schema.h"
#include "tracker/head_frame.h"
#include "tracker/landmarks.h"
#include "tracker/picture.h"

namespace zygoma {

class Mirror {
 public:
  // To be shown everything before it is used.
  void decide(const Frame& frame);
  void decide(const ContourSet& given, int width);
  bool turns() const { return turns_.value_or(false); }

  // From the way things are to the way they are looked at, ...
  Picture of(const Frame& frame) const { return Picture(frame, turns()); }
  // ... and back. `width` is that of the picture in px.
  ContourSet of(ContourSet set, int width) const;
  Landmarks of(const Landmarks& landmarks, int width) const;
  Similarity of(Similarity image_from_chart, int width) const;
  Correction of(Correction correction, int width) const;
  using Terms = std::array<ConfidenceTerms, kFeatureSchema.size()>;
  Terms of(Terms terms) const;

 private:
  std::optional<bool> turns_;
};

}  // namespace zygoma
