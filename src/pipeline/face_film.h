// Pictures of a face while it is simulated: a video of all frames, a still of the one that is
// furthest from rest, or both.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "face/contractions.h"
#include "face/state.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/overlay.h"

namespace zygoma {

class FaceFilm {
 public:
  // `lattice` is that of the face that moves, for overlays. An empty path: not wanted. `lattice`
  // and `track` must outlive the film. Throws InputError naming a path that cannot be written.
  FaceFilm(std::shared_ptr<const Anatomy> anatomy,
           const Lattice& lattice,
           const ContractionTrack& track,
           const std::string& video_path,
           const std::string& picture_path,
           const AnimateOptions& options);

  // `far_mm`: how far this frame is from rest.
  void take(int frame, const FaceState& state, double far_mm);

  // Writes the files.
  void finish();

 private:
  const cv::Mat& draw(int frame, const FaceState& state);

  std::shared_ptr<const Anatomy> anatomy_;
  const ContractionTrack& track_;
  std::string picture_path_;
  AnimateOptions options_;
  int face_px_;
  cv::Mat canvas_;
  std::optional<ContractionBars> bars_;
  Renderer renderer_;
  std::vector<Controls> controls_;  // per frame, if there is an overlay
  std::optional<FaceOverlay> overlay_;
  std::optional<VideoWriter> writer_;
  struct Furthest {
    int frame = -1;
    double far_mm = -1.0;
    FaceState state;
  } furthest_;
  std::vector<Vec3> skin_mm_;
};

}  // namespace zygoma
