#include "src/pipeline/face_film.h"

#include "src/io/picture_file.h"

namespace zygoma {

FaceFilm::FaceFilm(std::shared_ptr<const Anatomy> anatomy,
                   const Lattice& lattice,
                   const ContractionTrack& track,
                   const std::string& video_path,
                   const std::string& picture_path,
                   const AnimateOptions& options)
    : anatomy_(std::move(anatomy)),
      track_(track),
      picture_path_(picture_path),
      options_(options),
      face_px_(face_panels(options, height_alone_px(options)).face_px),
      renderer_(anatomy_, options.render) {
  const auto [height_px, face_px, bars_px] = face_panels(options, height_alone_px(options));
  canvas_ = cv::Mat(height_px, face_px + bars_px, CV_8UC3, cv::Scalar::all(0));
  if (options.bars) bars_.emplace(track.muscles, cv::Size(bars_px, height_px));
  if (options.overlay != Overlay::kNone) {
    controls_ = controls_for(track, *anatomy_);
    overlay_.emplace(options.overlay, *anatomy_, lattice);
  }
  if (!picture_path.empty()) require_picture_name(picture_path);
  if (!video_path.empty()) {
    writer_.emplace(video_path, canvas_.cols, canvas_.rows, average_rate(track), options.encoding);
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
