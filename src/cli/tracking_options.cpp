#include "src/cli/tracking_options.h"

#include "src/base/check.h"
#include "src/io/contours_file.h"
#include "src/io/corrections_file.h"
#include "src/io/landmarks_file.h"
#include "src/pipeline/correct_track.h"

namespace zygoma {

void TrackingOptions::declare(OptionSink& options) {
  options.number("--frame-rate",
                 frames_per_s_,
                 {0.0, 1000.0},
                 "frames/s of numbered pictures, of a raw stream, or asked of a camera; 0 = 25, or "
                 "the camera's own");
  options.text(
      "--init",
      init_path_,
      "FILE",
      "contours of the first frame (JSON: {\"contours\": {\"brow_left\": [[x, y], ...], ...}}) "
      "instead of the automatic start");
  options.text("--landmarks",
               landmarks_path_,
               "FILE",
               "68 landmarks per frame from another tracker (OpenFace's CSV)");
  options.choice("--landmarks-as",
                 landmarks_as_,
                 {"start", "prior"},
                 "start: they replace the automatic start and find the face again; prior: in every "
                 "frame contours are also drawn to them, and the picture refines");
  options.choice(
      "--second-look",
      second_look_,
      {"auto", "start", "all", "none"},
      "what is followed once more, backwards, and blended: the first second, in which the "
      "tracker still learns; the whole clip, which takes twice the time; or nothing, as "
      "live; auto: start, or as --quality says");
  options.text(
      "--corrections",
      corrections_path_,
      "FILE",
      "springs, pins and volcanoes that pull contours right, replayed on the track (a JSON "
      "object per line, see docs/formats.md)");
  options.text("--cascades",
               tracker_.cascade_folder,
               "FOLDER",
               "OpenCV's haarcascades (default: where its package puts them)");
  options.text("--landmark-model",
               tracker_.landmark_model,
               "FILE",
               "a model of yours that finds the face instead of the cascades: YuNet (.onnx) or an "
               "OpenCV Facemark of 68 landmarks (.yaml)");
  options.choice(
      "--stepping",
      stepping_,
      {"implicit", "explicit"},
      "how contours settle: implicit, or Euler's explicit steps as in 1992 (slower, same "
      "places)");
}

VideoSource TrackingOptions::source(const std::string& video_path) const {
  VideoSource source(video_path);
  source.frames_per_s = frames_per_s_;
  return source;
}

void TrackingOptions::leave_quality_to(const std::string& who) const {
  require(second_look_ == "auto", "--second-look: set by " + who + ", expected one or the other");
}

TrackedVideo TrackingOptions::track(const VideoSource& source,
                                    RunContext& context,
                                    TrackLimits limits) const {
  if (second_look_ == "start") limits.second_looks = SecondLooks::kStart;
  if (second_look_ == "all") limits.second_looks = SecondLooks::kAll;
  if (second_look_ == "none") limits.second_looks = SecondLooks::kNone;
  TrackGuidance guidance;
  if (!init_path_.empty()) guidance.initial = read_initial_contours(init_path_);
  LandmarkTrack landmarks;
  if (!landmarks_path_.empty()) {
    landmarks = read_landmarks_csv(landmarks_path_);
    guidance.landmarks = &landmarks;
  }
  guidance.landmarks_are_prior = landmarks_as_ == "prior";
  require(!guidance.landmarks_are_prior || guidance.landmarks != nullptr,
          "--landmarks-as prior: needs --landmarks");
  std::vector<Correction> corrections;
  if (!corrections_path_.empty()) corrections = read_corrections(corrections_path_);
  TrackerOptions tracker = tracker_;
  tracker.stepping = stepping_ == "explicit" ? SnakeStepping::kExplicit : SnakeStepping::kImplicit;
  TrackedVideo tracked =
      track_video(source, guidance, tracker, context.progress, context.stop, limits);
  try {
    correct_track(corrections, tracked, context.progress, context.stop);
  } catch (const InputError& error) {
    throw InputError(corrections_path_ + ": " + error.what());
  }
  return tracked;
}

}  // namespace zygoma
