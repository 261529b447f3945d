// The performer at rest: which frame is neutral, where its contours are, and how many millimetres
// of the face model one of its pixels is worth.
//
// Every contraction is read from displacements against this neutral, so it is taken from a stretch
// of frames (median), not from one noisy frame. Unless the user names the frame, stretches are
// ranked by how still they are, how closed the mouth and how narrow, how near brows and shape are
// to the clip's usual ones; the start of a clip gets a small bonus, as performers start at rest. Of
// the first few, that one is the neutral from which the model explains the clip best
// (retarget.cpp): as muscles only pull, a face that is not at rest leaves motion that nothing
// explains.
//
// The unit: distances that hardly change between people relative to each other (mouth width, brow
// span, brows to nose, nose to chin, brows to chin) are compared with the model's by least squares.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "retarget/correspondence.h"
#include "retarget/response.h"

namespace zygoma {

// One usable frame of the clip.
struct ObservedFrame {
  int frame_index = 0;
  double time_s = 0.0;
  StackedContours contours;
};

struct Neutral {
  int frame_index = -1;
  StackedContours contours;  // medians over the still stretch, pixels of the neutral frame
  int num_frames = 0;        // in that stretch
  double score = 0.0;        // how far it looks from a face at rest, in face sizes
};

// Median contours of the still stretch around `frame_index`. Throws InputError when that frame has
// no usable contours.
Neutral neutral_at(const std::vector<ObservedFrame>& frames, int frame_index);

// Stretches that may be the performer at rest, likeliest first by the rule above, at most
// `most`, none of which overlap.
std::vector<Neutral> neutral_candidates(const std::vector<ObservedFrame>& frames, int most);

// Why a face taken for neutral may not be: lips apart, a smile, left and right unlike. One short
// sentence each; empty when nothing is wrong. Against the model's face at rest, whose proportions
// are those of usual people.
std::vector<std::string> doubts_about(const Neutral& neutral, const FaceResponse& model);

// Distances between features, as shares of the size of the face: they tell people apart. NaN where
// a feature is not seen.
Eigen::VectorXd face_proportions(const StackedContours& contours);

// RMS relative difference of the proportions that both have; 0 if they share none.
double proportion_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

// The performer against the model: model_mm = millimetre_per_px R(-roll) (image_px - centre_px).
struct PerformerFrame {
  Point2 centre_px{0.0, 0.0};
  double roll_rad = 0.0;  // of the neutral head against the upright model
  double millimetre_per_px = 1.0;
  double face_unit_px = 0.0;  // brows to chin, as the model has it, in the neutral frame
  NodeStack neutral_mm = NodeStack::Zero();  // the neutral contours in this frame

  Point2 to_mm(const Point2& image_px) const;
  Point2 to_px(const Point2& model_mm) const;
};

PerformerFrame measure_performer(const Neutral& neutral, const FaceResponse& model);

}  // namespace zygoma
