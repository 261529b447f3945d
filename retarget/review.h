// What a user should know of an estimated track: how well the model's contours meet the tracked
// ones, which contour explains which contraction, and the frames that want a human eye.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "retarget/retarget.h"

namespace zygoma {

struct ContourFit {
  std::string contour;
  int num_frames = 0;
  double median_px = 0.0;  // RMS distance of a frame's nodes, median over frames
  double p90_px = 0.0;
  double median_percent = 0.0;  // of the size of the face, brows to chin
};

// Row of the influence matrix of one control, in the frame where it is strongest.
struct ControlEvidence {
  std::string control;  // a muscle, or "jaw"
  int frame_index = 0;
  double strongest = 0.0;
  double observed_share = 0.0;               // of the frames
  std::array<double, kNumContours> share{};  // of the variance that the contours pass on; sums to 1
};

struct SuspectFrame {
  int frame_index = 0;
  double time_s = 0.0;
  double badness = 0.0;  // 1: as bad as a frame may be without being looked at
  std::string reason;
};

struct RetargetReview {
  std::vector<ContourFit> contours;
  std::vector<ControlEvidence> controls;
  std::vector<SuspectFrame> suspects;  // worst first, some time apart
};

RetargetReview review(const ContractionTrack& track, const RetargetReport& report);

}  // namespace zygoma
