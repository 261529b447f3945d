// The performer at rest: which frame is neutral, where its contours are, and how many millimetres
// of the face model one of its pixels is worth.
//
// Every contraction is read from displacements against this neutral, so it is taken from a stretch
// of frames (median), not from one noisy frame. Unless the user names the frame, the stretch is the
// stillest one whose mouth is closed, whose brows are low and whose shape is near the clip's usual
// one; the start of a clip gets a small bonus, as performers start at rest.
//
// The unit: distances that hardly change between people relative to each other (mouth width, brow
// span, brows to nose, nose to chin, brows to chin) are compared with the model's by least squares.
#pragma once

#include <Eigen/Core>
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
};

// Median contours of the still stretch around `frame_index`, or around the frame found by the rule
// above if it is -1. Throws InputError when that frame has no usable contours.
Neutral find_neutral(const std::vector<ObservedFrame>& frames, int frame_index);

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
