// What the face is told to do in one frame, and what the retarget stage says about a performer:
// one contraction in [0, 1] per muscle, the jaw, and where the head was.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace zygoma {

// Head in the image: similarity against the performer's neutral frame.
struct HeadPose {
  double x_px = 0.0;  // head reference point
  double y_px = 0.0;
  double scale = 1.0;     // 1 = neutral
  double roll_rad = 0.0;  // positive = clockwise on the screen
  bool operator==(const HeadPose&) const = default;
};

struct Contractions {
  int frame_index = 0;
  double time_s = 0.0;
  double confidence = 0.0;  // [0, 1], smallest over the contours that drive something
  bool success = false;     // all driving contours were tracked
  HeadPose head;
  double jaw = 0.0;           // [0, 1] of Jaw::full_rad
  double jaw_sigma = 0.0;     // posterior standard deviation
  std::vector<double> value;  // [0, 1], in the order of the muscle names that go with it
  std::vector<double> sigma;  // posterior standard deviation; empty if not estimated
  // Whether the picture says more of a control than the prior does; empty if not estimated.
  std::vector<bool> observed;
  bool jaw_observed = false;
  std::vector<std::pair<std::string, double>>
      residual_px;  // RMS per contour, contour against model

  bool operator==(const Contractions&) const = default;
};

// A sequence and the names its values go by.
struct ContractionTrack {
  std::vector<std::string> muscles;
  std::vector<Contractions> frames;
  bool operator==(const ContractionTrack&) const = default;
};

}  // namespace zygoma
