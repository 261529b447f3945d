#include "src/pipeline/animate_face.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/check.h"
#include "src/io/video_reader.h"
#include "src/pipeline/overlay.h"
#include "src/pipeline/producer.h"

namespace zygoma {
namespace {

constexpr double kLookAtY_mm = -28.0;  // between the pupils and the lips: centre of the picture
constexpr double kPictureHeight_mm = 300.0;  // crown to below the chin
constexpr double kReleasePerFrame = 0.85;    // of a contraction whose performer was lost

struct SettledFrame {
  std::vector<Vec3> skin_mm;
  FaceState state;
  SettleReport report;
  double settle_ms = 0.0;
};

// Settles the face frame by frame, each from where the one before left it.
class SettledFrames {
 public:
  SettledFrames(Simulator& face, const std::vector<Controls>& controls)
      : face_(face), controls_(controls), state_(face.rest()) {}

  std::optional<SettledFrame> next() {
    if (next_ == controls_.size()) return std::nullopt;
    const double begin_ms = thread_ms();
    SettledFrame frame;
    frame.report = face_.settle(controls_[next_++], state_);
    frame.settle_ms = thread_ms() - begin_ms;
    embed_skin(face_.anatomy(), state_, frame.skin_mm);
    frame.state = state_;
    return frame;
  }

 private:
  Simulator& face_;
  const std::vector<Controls>& controls_;
  FaceState state_;
  std::size_t next_ = 0;
};

void count(const SettledFrame& frame, AnimationReport& report) {
  report.settle_figures.total_ms += frame.settle_ms;
  ++report.num_frames;
  if (!frame.report.converged) ++report.frames_not_converged;
  report.most_inverted_elements =
      std::max(report.most_inverted_elements, frame.report.inverted_elements);
  report.largest_volume_change =
      std::max(report.largest_volume_change, frame.report.mean_volume_change);
}

// Head roll over the clip, smoothed with a zero-lag window: the tracked roll is noisy from frame to
// frame and a head is heavy.
std::vector<double> smooth_roll_rad(const ContractionTrack& track) {
  constexpr int kHalfWindow = 4;
  const int n = static_cast<int>(track.frames.size());
  std::vector<double> roll(n, 0.0);
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    double weight_sum = 0.0;
    for (int k = std::max(0, i - kHalfWindow); k <= std::min(n - 1, i + kHalfWindow); ++k) {
      if (track.frames[k].value.empty()) continue;
      const double weight = 1.0 - std::abs(k - i) / (kHalfWindow + 1.0);
      sum += weight * track.frames[k].head.roll_rad;
      weight_sum += weight;
    }
    if (weight_sum > 0.0) roll[i] = sum / weight_sum;
  }
  return roll;
}

// The performer's picture with its contours, scaled to the panel; nothing when the video ends
// before the track does.
class PerformancePanel {
 public:
  // height_px 0: the video's own, within reason.
  PerformancePanel(const Performance& performance, int height_px)
      : performance_(performance), reader_(performance.video) {
    const VideoInfo& info = reader_.info();
    if (height_px == 0) height_px = std::clamp(info.height_px, 240, 720);
    scale_ = static_cast<double>(height_px) / info.height_px;
    size_ = {2 * static_cast<int>(std::lround(0.5 * scale_ * info.width_px)), height_px};
  }

  cv::Size size() const { return size_; }

  std::optional<cv::Mat> next() {
    if (!reader_.read(frame_)) return std::nullopt;
    cv::Mat panel;
    if (frame_.image.size() == size_) {
      panel = frame_.image.clone();
    } else {
      const auto how = scale_ < 1.0 ? cv::INTER_AREA : cv::INTER_CUBIC;
      cv::resize(frame_.image, panel, size_, 0.0, 0.0, how);
    }
    if (next_ < performance_.contours.size()) {
      draw_contours(performance_.contours[next_++], enlargement(scale_), {}, panel);
    }
    return panel;
  }

 private:
  const Performance& performance_;
  VideoReader reader_;
  double scale_ = 1.0;
  cv::Size size_;
  Frame frame_;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<Controls> controls_for(const ContractionTrack& track, const Anatomy& anatomy) {
  std::vector<int> index;
  for (const std::string& name : track.muscles) {
    index.push_back(anatomy.muscle_index(name));
    require(index.back() >= 0, "muscle '" + name + "': this face has no muscle of that name");
  }
  std::vector<Controls> controls;
  controls.reserve(track.frames.size());
  Controls now;
  now.contraction.assign(anatomy.muscles.size(), 0.0);
  for (const Contractions& frame : track.frames) {
    const std::string place = " in frame " + std::to_string(frame.frame_index);
    if (frame.value.empty()) {
      for (double& c : now.contraction) c *= kReleasePerFrame;
      now.jaw_rad *= kReleasePerFrame;
    } else {
      require(frame.value.size() == index.size(),
              "contractions" + place + ": " + std::to_string(frame.value.size()) +
                  " values, expected one for each of " + std::to_string(index.size()) + " muscles");
      for (std::size_t i = 0; i < index.size(); ++i) {
        require(frame.value[i] >= 0.0 && frame.value[i] <= 1.0,
                track.muscles[i] + place + ": " + std::to_string(frame.value[i]) +
                    ", expected a contraction in [0, 1]");
        now.contraction[index[i]] = frame.value[i];
      }
      require(frame.jaw >= 0.0 && frame.jaw <= 1.0,
              "jaw" + place + ": " + std::to_string(frame.jaw) + ", expected [0, 1]");
      now.jaw_rad = frame.jaw * anatomy.jaw.full_rad;
    }
    controls.push_back(now);
  }
  return controls;
}

double average_rate(const ContractionTrack& track) {
  const double span_s = track.frames.back().time_s - track.frames.front().time_s;
  const auto steps = static_cast<double>(track.frames.size() - 1);
  return span_s > 0.0 ? steps / span_s : 30.0;
}

FacePanels face_panels(const AnimateOptions& options, int height_px) {
  return {height_px, 2 * (height_px * 2 / 5), options.bars ? 2 * (height_px * 6 / 25) : 0};
}

int height_alone_px(const AnimateOptions& options) {
  constexpr int kUsual_px = 480;
  return options.panel_height_px > 0 ? options.panel_height_px : kUsual_px;
}

Camera face_camera(int width_px, int height_px, double roll_rad) {
  Camera camera = make_camera(width_px, height_px, {0.0, kLookAtY_mm, 0.0}, kPictureHeight_mm);
  // A roll on the screen is a turn of the camera frame about its z axis (x right, y down).
  camera.camera_from_face = Eigen::AngleAxisd(roll_rad, Vec3::UnitZ()) * camera.camera_from_face;
  return camera;
}

Camera camera_of(const AnimateOptions& options,
                 const Anatomy& anatomy,
                 const cv::Size& size_px,
                 double roll_rad,
                 double share) {
  if (!options.view) return face_camera(size_px.width, size_px.height, roll_rad);
  return view_camera(*options.view, anatomy, size_px.width, size_px.height, share);
}

AnimationReport animate_face(const ContractionTrack& track,
                             Simulator& face,
                             std::shared_ptr<const Anatomy> anatomy,
                             const std::optional<Performance>& performance,
                             const std::string& output,
                             const AnimateOptions& options,
                             StageObserver& observer,
                             const StopQuestion& stop) {
  require(!track.frames.empty(), output + ": nothing to animate, the track has no frame");
  const std::vector<Controls> controls = controls_for(track, *anatomy);
  const std::vector<double> roll_rad = smooth_roll_rad(track);
  const int num_frames = static_cast<int>(track.frames.size());

  std::optional<PerformancePanel> panel;
  if (performance) panel.emplace(*performance, options.panel_height_px);
  const auto [height_px, face_px, bars_px] =
      face_panels(options, panel ? panel->size().height : height_alone_px(options));
  const int left_px = panel ? panel->size().width : 0;
  cv::Mat canvas(height_px, left_px + face_px + bars_px, CV_8UC3, cv::Scalar::all(0));
  cv::Mat left = canvas.colRange(0, left_px);
  cv::Mat right = canvas.colRange(left_px, left_px + face_px);
  cv::Mat bars = canvas.colRange(left_px + face_px, canvas.cols);
  const ContractionBars chart(track.muscles, bars.size());

  Renderer renderer(anatomy, options.render);
  FaceOverlay overlay(options.overlay, *anatomy, face.lattice());
  VideoWriter writer(output, canvas.cols, canvas.rows, average_rate(track), options.encoding);
  AnimationReport report;
  report.settle_figures.name = "settle";
  report.render_figures.name = "render";
  observer.begin("animate", num_frames);
  const Stopwatch watch;
  {
    SettledFrames frames(face, controls);
    Producer<SettledFrame> settled(3, [&] { return frames.next(); });
    Producer<cv::Mat> pictures(3, [&]() { return panel ? panel->next() : std::nullopt; });

    cv::Mat picture;
    for (int i = 0; i < num_frames; ++i) {
      const std::optional<SettledFrame> frame = settled.next();
      if (const std::optional<cv::Mat> seen = pictures.next()) seen->copyTo(left);
      const Stopwatch render_watch;
      const double share = static_cast<double>(i) / num_frames;
      const Camera camera = camera_of(options, *anatomy, {face_px, height_px}, roll_rad[i], share);
      renderer.render(
          frame->skin_mm, frame->state.jaw_rad, camera, picture, overlay.tint(frame->state));
      overlay.draw(controls[i], frame->state, camera, picture);
      picture.copyTo(right);
      report.render_figures.total_ms += render_watch.elapsed_ms();
      if (options.bars) chart.draw(track.frames[i], bars);
      writer.write(canvas, track.frames[i].time_s);

      count(*frame, report);
      observer.update(report.num_frames);
      if (stop && stop()) {
        report.stopped = true;
        break;
      }
    }
  }
  writer.finish();
  observer.end();
  report.figures = {"animate", report.num_frames, watch.elapsed_ms()};
  report.settle_figures.num_frames = report.num_frames;
  report.render_figures.num_frames = report.num_frames;
  return report;
}

}  // namespace zygoma
