// Follows the contours through a video, frame by frame: predict, relax, judge, recover
// (paper, section 6, with the corrections of docs/tracking.md).
#pragma once

#include <memory>
#include <string>

#include "tracker/confidence.h"
#include "tracker/contour_set.h"
#include "tracker/feature_schema.h"
#include "tracker/frame.h"
#include "tracker/head_frame.h"
#include "tracker/lip_map.h"
#include "tracker/mirror.h"
#include "tracker/snake.h"

namespace zygoma {

// Where nodes are expected before the picture has its say.
enum class PredictBy {
  kNothing,    // where they were, as in 1992; the motion of the head is taken off all the same
  kLastFrame,  // where optical flow from the last frame puts them: drifts
  kLooks,      // also by flow from the remembered look that resembles this one most
};

// What is done for accuracy and paid for in time (docs/accuracy-and-time.md).
struct TrackerEffort {
  PredictBy predict_by = PredictBy::kLooks;
  // Of mouth and lids: they draw the prediction. Without them snakes and flow are on their
  // own.
  bool models = true;
  // The snakes relax on so many landscapes, each smoothed twice as widely as the next, the finest
  // last; [1, 4]. Large: edges attract from further away, also the wrong ones.
  int gaussian_levels = 1;
  // Of a snake, multiples of what is put out, [0.4, 8]. The chain is the same at any number.
  double nodes = 1.0;
  double tolerance_px = 0.005;  // of a snake, [1e-9, 1] chart px
  int max_iterations = 60;      // of a snake in one frame, [1, 100000]

  // Throws InputError naming the first value outside its range.
  void check() const;
};

struct TrackerOptions {
  std::string cascade_folder;  // OpenCV's haarcascades; empty: the places where packages put them
  std::string landmark_model;  // of the user (landmark_finder.h); empty: the cascades find the face
  // Frames in a row that may go by without sight of the face before its contours are given up,
  // [0, 1000]. Small: a hand before the face ends the track; large: a scene cut is noticed late.
  int max_coast_frames = 3;
  // Strength of the spring from a node to where optical flow saw it go, [0, 100], against an image
  // force of about one. Small: nodes slide along edges; large: the drift of the flow stays.
  double flow_hold = 0.3;
  // Share of the mouth model in where the lip contours are drawn to before they relax, the rest is
  // optical flow's, [0, 1]. Small: lips slip to inner edges; large: only symmetric mouths.
  double model_share = 0.5;
  // Share of a prior (set_prior) in where contours are drawn to before they relax, [0, 1]. Small:
  // it hardly helps; large: its noise stays.
  double prior_share = 0.35;
  // The start is made again, once or twice in its first second, when the face has become sharper by
  // this factor, > 1. Small: a needless jump; large: a start on blocky frames is never mended.
  double sharper = 1.2;
  // A look at the mouth or the brows that resembles every remembered one less than this is
  // remembered too, (0, 1). Small: flow must bridge large changes; large: drift is remembered.
  double new_look_correlation = 0.85;
  // How the snakes step; both come to rest in the same places (snake.h).
  SnakeStepping stepping = SnakeStepping::kImplicit;
  TrackerEffort effort;

  // Throws InputError naming the first value outside its range.
  void check() const;
};

// How the last frame went; data, never an exception.
struct TrackReport {
  bool face_found = false;
  bool started = false;      // all contours were placed anew
  int num_lost = 0;          // contours without a position in this frame
  int relax_iterations = 0;  // summed over contours
  // Why the confidences are what they are; of contours without a position, of when they had one.
  std::array<ConfidenceTerms, kFeatureSchema.size()> terms{};
};

class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  // Uses these contours instead of the automatic start on the next frame. Contours that are
  // missing are placed by the template fitted to those given. Throws InputError naming the contour
  // if a point is not finite.
  void start_from(const ContourSet& initial);
  void start_from(const Landmarks& initial);

  // Where another tracker sees the contours of the next frame: they are drawn there, and the
  // picture refines. Contours that are missing or lost are not drawn anywhere.
  void set_prior(const ContourSet& prior);
  void set_prior(const Landmarks& prior);

  // The contours of the next frame. Until a face is found, a set whose contours are all lost.
  ContourSet track(const Frame& frame);

  const TrackReport& report() const;

  // A tracker in the same state that has forgotten all looks but the last: to follow the frames in
  // reverse.
  Tracker looking_back() const;

  // Where the face was in the last frame, image from chart; null if it was not found.
  const Similarity* head() const;
  // What skin and lips of this face look like.
  const LipMap& lips() const;
  // Which way round the pictures are looked at.
  const Mirror& mirror() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
