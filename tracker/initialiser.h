// Places the contours on a face chart without any history.
//
// A template of the face in eye distances is fitted feature by feature: a few parameters each
// (height, width, tilt, arch) are searched exhaustively for the most evidence under the curve, with
// a Gaussian prior from the usual proportions of faces. Only then do snakes take over, coarse to
// fine: the search finds the right ravine, the snake its bottom.
#pragma once

#include <array>

#include "tracker/contour_set.h"
#include "tracker/evidence.h"
#include "tracker/lid_model.h"
#include "tracker/mouth_model.h"

namespace zygoma {

// The contours of an average face, chart pixels, schema order.
ContourNodes template_contours();

// What a search of one chart finds.
struct PlacedFace {
  ContourNodes contours;
  LipMap lips;  // its skin
  Mouth mouth;
  Mouth rest;  // the same when closed
  Lid left_lid, right_lid;
};

// Never fails: without evidence the template stays where it is.
PlacedFace place_contours(const FaceChart& chart);

// Where the furrow of one side usually runs: from beside the wing of the nose to beside the corner
// of the mouth.
std::vector<Point2> furrow_between(const std::vector<Point2>& nose_tip,
                                   const std::vector<Point2>& upper_lip,
                                   bool left);

// The lips meet in the corners of the mouth.
void join_lip_ends(ContourNodes& contours);

// Snake constants per feature, for a chart's scale.
SnakeOptions snake_options(FeatureIndex feature);

}  // namespace zygoma
