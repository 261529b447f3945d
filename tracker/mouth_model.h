// The outline of the mouth as seven numbers, fitted to the lip map as a region.
//
// A snake on the lip border knows only the edge under it; when the mouth opens or purses between
// two frames it can settle on a neighbouring edge or shrink along its own. The model looks at the
// whole: it gains from every pixel of the map inside the outline above a threshold and loses from
// every one below it,
//   gain = sum_inside (m - 0.45) / area of a usual mouth,
// which has one broad maximum, pays for reaching the corners, and is blind to what the inside looks
// like (lips, teeth, tongue, dark). Edge evidence sharpens the maximum. The snakes then start from
// the right place.
#pragma once

#include <vector>

#include "tracker/evidence.h"
#include "tracker/shape_search.h"

namespace zygoma {

// Eye distances in the chart: height of the corners' middle, of the middle of the upper lip above
// it and of the lower below it, middle x, half width, tilt (half the height difference of the
// corners, left lower positive), bend (how far the middle hangs below the corners: a smile).
struct Mouth {
  enum Parameter { kHeight, kLower, kUpper, kMiddle, kHalfWidth, kTilt, kBend, kNumParameters };
  std::vector<double> p{1.15, 0.16, 0.13, 0.0, 0.375, 0.0, 0.0};
};

std::vector<Point2> lip_nodes(const Mouth& mouth, bool upper);

// Without history: over all mouths about a usual one. `use_region` only with a learned lip map.
// `line_cost`, [0, 1], of an upper border on a dark line: where the upper lip is pale the seam has
// the stronger edge, but that is where it ends.
Mouth find_mouth(const Evidence& evidence, const Mouth& usual, bool use_region, double line_cost);
// With history: the better of climbs from the last mouth and from the most promising of the
// person's resting mouth closed, open and smiling, so that no quick move leaves the search in the
// wrong hollow. The prior holds the last mouth.
Mouth follow_mouth(const Evidence& evidence, const Mouth& last, const Mouth& rest);

}  // namespace zygoma
