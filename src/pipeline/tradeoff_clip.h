// The tracker and the estimation of tradeoff.h, on a clip.
//
// The contours that the estimation is given are those of the usual tracker, whatever else was
// tried, so that each stage is judged by itself.
#pragma once

#include <string>
#include <vector>

#include "face/scene.h"
#include "retarget/retarget.h"
#include "src/pipeline/track_video.h"
#include "src/pipeline/tradeoff.h"

namespace zygoma {

// A clip and what is known of it.
struct TradeoffClip {
  VideoSource video;
  double duration_s = 0.0;                // of what is used, from the start; 0: all
  std::vector<ContourSet> true_contours;  // empty: unknown
  ContractionTrack true_contractions;     // no frames: unknown
};

struct TrackerChoice {
  std::string name;  // a level of --quality, or empty
  std::string family;
  std::string words;
  TrackerOptions options;
  SecondLooks second_looks = SecondLooks::kStart;
};

struct RetargetChoice {
  std::string name;
  std::string family;
  std::string words;
  RetargetOptions options;
};

std::vector<TrackerChoice> tracker_choices();
TrackerChoice tracker_reference();  // does everything, and to the end
std::vector<RetargetChoice> retarget_choices();
RetargetChoice retarget_reference();

// Error: how far contours miss the motion of the true ones (ContourError::motion_median_px), mean
// over the nine; other_error: how far they are from them, constant offsets included.
TradeoffStage measure_tracker(const TradeoffClip& clip,
                              const std::vector<TrackerChoice>& choices,
                              const TrackerChoice& reference,
                              StageObserver& observer,
                              const StopQuestion& stop);

// Error: RMS over muscles, jaw and frames; other_error: median distance in px of contours from
// where the face, so contracted, has them. `scene` is the face of the estimation.
TradeoffStage measure_retarget(const TradeoffClip& clip,
                               const Scene& scene,
                               const std::vector<RetargetChoice>& choices,
                               const RetargetChoice& reference,
                               StageObserver& observer,
                               const StopQuestion& stop);

}  // namespace zygoma
