// Finds the mouth in a first picture, be it closed, open or smiling with teeth.
//
// The lip map is learned from an outline, and the outline found in the lip map: a wrong outline
// teaches a map that confirms it. A mouth that is open at the start was taken for its upper lip and
// the dark below, with the lower lip learned as skin. So the search starts from several usual
// mouths, each learns its own map, and what is found is judged by what none of them learned: an
// outline is right if it parts the picture into two regions that are each as uniform as can be. The
// cost is the code length of both regions' colours under a Gaussian each, per pixel (nats),
//   e = sum_r n_r / 2 log det C_r / sum_r n_r,   r: inside, and around up to a margin,
// the piecewise smooth model of Mumford & Shah 1989 with colours for intensities (Zhu & Yuille
// 1996).
//
// The shade below the lower lip is the one thing that this takes for a lip. An outline of an open
// mouth must therefore be better than that of a closed one by kShade, in so far as there is colour
// to tell them by. In the same measure an upper border on a dark line costs: a pale upper lip was
// left out, and the outline begun on the seam.
#pragma once

#include "tracker/face_chart.h"
#include "tracker/lip_map.h"
#include "tracker/mouth_model.h"

namespace zygoma {

struct MouthStart {
  Mouth mouth;
  Mouth rest;   // the same when closed, as far as can be told
  LipMap lips;  // not learned if no outline taught anything
};

MouthStart start_mouth(const FaceChart& chart);

}  // namespace zygoma
