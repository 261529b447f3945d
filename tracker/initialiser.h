// Places the nine contours on a face chart without any history.
//
// A template of the face in eye distances is fitted feature by feature: a few parameters each
// (height, width, tilt, arch) are searched exhaustively for the most evidence under the curve, with
// a Gaussian prior from the usual proportions of faces. Only then do snakes take over, coarse to
// fine: the search finds the right ravine, the snake its bottom.
#pragma once

#include <array>

#include "tracker/contour_set.h"
#include "tracker/evidence.h"
#include "tracker/mouth_model.h"

namespace zygoma {

// The contours of an average face, chart pixels, schema order.
ContourNodes template_contours();

// The contours of this face, its skin learned into `lips`, the model of its mouth. Never fails:
// without evidence the template stays where it is.
ContourNodes place_contours(const FaceChart& chart, LipMap& lips, Mouth& mouth);

// Snake constants per feature, for a chart's scale.
SnakeOptions snake_options(FeatureIndex feature);

}  // namespace zygoma
