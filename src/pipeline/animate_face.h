// Last stage: contractions in, a video of the physical face out; beside the performer's video with
// its contours when that is given.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "face/generic_head.h"
#include "face/simulator.h"
#include "src/base/stop.h"
#include "src/io/video_source.h"
#include "src/io/video_writer.h"
#include "src/pipeline/stage_figures.h"
#include "src/pipeline/stage_observer.h"
#include "src/render/face_overlay.h"
#include "src/render/renderer.h"
#include "src/render/views.h"
#include "tracker/contour_set.h"

namespace zygoma {

// The performer's video and its contours, drawn to the left of the face.
struct Performance {
  VideoSource video;
  std::vector<ContourSet> contours;  // one per frame of the track
};

struct AnimateOptions {
  int panel_height_px = 0;   // of every panel; 0: the video's, kept within [240, 720]
  bool bars = true;          // a panel with one bar per muscle
  std::optional<View> view;  // of the whole head; none: from the front, close, with the head's roll
  Overlay overlay = Overlay::kNone;
  RenderOptions render;
  VideoWriterOptions encoding;
};

struct AnimationReport {
  int num_frames = 0;
  int frames_not_converged = 0;
  int most_inverted_elements = 0;
  double largest_volume_change = 0.0;  // over frames, of the mean |V - V0| / V0
  bool stopped = false;
  StageFigures figures;         // wall time of the whole stage
  StageFigures settle_figures;  // processor time of settling alone
  StageFigures render_figures;
};

// One Controls per frame of the track for this face, muscles joined by name. Frames without values
// relax towards rest from the last known ones, so that a lost face does not freeze in a grimace.
// Throws InputError naming a muscle that the face does not have and a value outside [0, 1].
std::vector<Controls> controls_for(const ContractionTrack& track, const Anatomy& anatomy);

// Frames a second, on average; 30 if there is one frame only.
double average_rate(const ContractionTrack& track);

// Sizes of the panels of a picture that high, all even.
struct FacePanels {
  int height_px = 0;
  int face_px = 0;  // width
  int bars_px = 0;  // the same; 0 = none
};
FacePanels face_panels(const AnimateOptions& options, int height_px);

// How high a picture of the face alone is.
int height_alone_px(const AnimateOptions& options);

// What a face is filmed with when no view is asked for: from the front, close; `roll_rad` is that
// of the head.
Camera face_camera(int width_px, int height_px, double roll_rad = 0.0);

// As the options say; `share` of the animation is over: a turntable turns once.
Camera camera_of(const AnimateOptions& options,
                 const Anatomy& anatomy,
                 const cv::Size& size_px,
                 double roll_rad,
                 double share);

// Settles, draws and encodes every frame of the track into the file `output`. A stop leaves a valid
// file with the frames done so far.
AnimationReport animate_face(const ContractionTrack& track,
                             Simulator& face,
                             std::shared_ptr<const Anatomy> anatomy,
                             const std::optional<Performance>& performance,
                             const std::string& output,
                             const AnimateOptions& options,
                             StageObserver& observer,
                             const StopQuestion& stop);

}  // namespace zygoma
