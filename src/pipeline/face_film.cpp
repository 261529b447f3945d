#include "src/pipeline/face_film.h"

#include "src/io/picture_file.h"

namespace zygoma {
namespace {

constexpr int kUsualHeight_px = 480;

int height_of(const AnimateOptions& options) {
  return options.panel_height_px > 0 ? options.panel_height_px : kUsualHeight_px;
}

double rate_of(const ContractionTrack& track) {
  const double span_s = track.frames.back().time_s - track.frames.front().time_s;
  return span_s > 0.0 ? static_cast<double>(track.frames.size() - 1) / span_s : 30.0;
}

}  // namespace

FaceFilm::FaceFilm(std::shared_ptr<const Anatomy> anatomy,
                   const LatticeOptions& lattice,
                   const ContractionTrack& track,
                   const std::string& video_path,
                   const std::string& picture_path,
                   const AnimateOptions& options)
    : anatomy_(std::move(anatomy)),
      track_(track),
      picture_path_(picture_path),
      options_(options),
      face_px_(2 * (height_of(options) * 2 / 5)),
      renderer_(anatomy_, options.render) {
  const int height_px = height_of(options);
  const int bars_px = options.bars ? 2 * (height_px * 6 / 25) : 0;
  canvas_ = cv::Mat(height_px, face_px_ + bars_px, CV_8UC3, cv::Scalar::all(0));
  if (options.bars) bars_.emplace(track.muscles, cv::Size(bars_px, height_px));
  if (options.overlay != Overlay::kNone) {
    controls_ = controls_for(track, *anatomy_);
    lattice_ = make_lattice(*anatomy_, lattice);
    overlay_.emplace(options.overlay, *anatomy_, lattice_);
  }
  if (!picture_path.empty()) require_picture_name(picture_path);
  if (!video_path.empty()) {
    writer_.emplace(video_path, canvas_.cols, canvas_.rows, rate_of(track), options.encoding);
  }
}

void FaceFilm::take(int frame, const FaceState& state, double far_mm) {
  if (writer_) writer_->write(draw(frame, state), track_.frames[frame].time_s);
  if (far_mm > furthest_.far_mm) furthest_ = {frame, far_mm, state};
}

void FaceFilm::finish() {
  if (writer_) writer_->finish();
  if (picture_path_.empty() || furthest_.frame < 0) return;
  write_picture(picture_path_, draw(furthest_.frame, furthest_.state));
}

const cv::Mat& FaceFilm::draw(int frame, const FaceState& state) {
  const double share = static_cast<double>(frame) / static_cast<double>(track_.frames.size());
  const Camera camera = camera_of(options_, *anatomy_, {face_px_, canvas_.rows}, 0.0, share);
  cv::Mat picture;
  embed_skin(*anatomy_, state, skin_mm_);
  renderer_.render(
      skin_mm_, state.jaw_rad, camera, picture, overlay_ ? overlay_->tint(state) : nullptr);
  if (overlay_) overlay_->draw(controls_[frame], state, camera, picture);
  picture.copyTo(canvas_.colRange(0, face_px_));
  cv::Mat bars = canvas_.colRange(face_px_, canvas_.cols);
  if (bars_) bars_->draw(track_.frames[frame], bars);
  return canvas_;
}

}  // namespace zygoma
