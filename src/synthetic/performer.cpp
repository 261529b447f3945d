#include "src/synthetic/performer.h"

#include <algorithm>
#include <cmath>

#include "face/simulator.h"
#include "src/base/check.h"
#include "src/render/camera.h"
#include "src/render/renderer.h"
#include "src/synthetic/person.h"
#include "src/synthetic/random.h"
#include "src/synthetic/schedule.h"
#include "tracker/feature_schema.h"
#include "tracker/snake.h"

namespace zygoma {
namespace {

constexpr double kFaceShare = 0.5;  // of the picture's height, chin to hairline

using Polyline = std::vector<Point2>;

// The contours as the camera sees them.
ContourSet project_contours(const Anatomy& anatomy,
                            const std::vector<Vec3>& skin_mm,
                            const Camera& camera) {
  ContourSet set;
  for (const Feature& feature : kFeatureSchema) {
    Contour contour;
    contour.name = feature.name;
    for (const NamedCurve& curve : anatomy.curves) {
      if (curve.name != feature.name || curve.skin_vertices.size() < 2) continue;
      Polyline line;
      for (const int vertex : curve.skin_vertices) {
        line.push_back(camera.project(skin_mm[static_cast<std::size_t>(vertex)]));
      }
      contour.points_px = resample(line, feature.num_nodes);
      contour.confidence = 1.0;
    }
    set.contours.push_back(std::move(contour));
  }
  return set;
}

Polyline all_points(const ContourSet& set) {
  Polyline points;
  for (const Contour& contour : set.contours) {
    points.insert(points.end(), contour.points_px.begin(), contour.points_px.end());
  }
  return points;
}

Point2 mean_of(const Polyline& points) {
  Point2 sum = Point2::Zero();
  for (const Point2& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// Scale and roll of the resting face between two frames, by least squares; reference point of the
// second.
HeadPose true_pose(const ContourSet& first, const ContourSet& now) {
  const Polyline from = all_points(first);
  const Polyline to = all_points(now);
  const Point2 from_mean = mean_of(from);
  const Point2 to_mean = mean_of(to);
  double square = 0.0;
  double along = 0.0;
  double across = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Point2 p = from[i] - from_mean;
    const Point2 q = to[i] - to_mean;
    square += p.squaredNorm();
    along += p.dot(q);
    across += p.x() * q.y() - p.y() * q.x();
  }
  HeadPose pose;
  pose.scale = std::hypot(along, across) / square;
  pose.roll_rad = std::atan2(across, along);
  const Contour* hairline = now.visible("hairline");
  const Point2 reference = hairline != nullptr ? mean_of(hairline->points_px) : to_mean;
  pose.x_px = reference.x();
  pose.y_px = reference.y();
  return pose;
}

// Additive camera noise, the same for the same seed and frame.
void add_noise(cv::Mat& bgr, double sigma, std::uint32_t seed, int frame_index) {
  if (sigma <= 0.0) return;
  RandomStream random(seed, 1000 + static_cast<std::uint64_t>(frame_index));
  const auto amplitude = static_cast<float>(sigma);
  for (int y = 0; y < bgr.rows; ++y) {
    std::uint8_t* row = bgr.ptr<std::uint8_t>(y);
    for (int i = 0; i < 3 * bgr.cols; ++i) {
      const float value = static_cast<float>(row[i]) + amplitude * random.normal();
      row[i] = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
    }
  }
}

Camera frame_the_face(const Anatomy& anatomy, int width_px, int height_px) {
  double top = -1e9;
  double bottom = 1e9;
  for (const NamedCurve& curve : anatomy.curves) {
    for (const int vertex : curve.skin_vertices) {
      const double y = anatomy.skin.mesh.positions_mm[static_cast<std::size_t>(vertex)].y();
      top = std::max(top, y);
      bottom = std::min(bottom, y);
    }
  }
  require(top > bottom, "the face model has no named curves; expected the nine contours");
  const double height_mm = (top - bottom) / kFaceShare;
  // In a narrow picture the width is what limits the face.
  const double narrow_mm = 1.4 * (top - bottom) * height_px / width_px;
  const Vec3 centre(0.0, 0.5 * (top + bottom), 0.0);
  return make_camera(width_px, height_px, centre, std::max(height_mm, narrow_mm));
}

}  // namespace

void PerformerOptions::check() const {
  require_range("duration_s", duration_s, 1e-3, 600.0);
  require_range("frames_per_s", frames_per_s, 5.0, 120.0);
  require_range("width_px", width_px, 64, 4096);
  require_range("height_px", height_px, 64, 4096);
  require_range("noise_grey_levels", noise_grey_levels, 0.0, 40.0);
  require_range("sway", sway, 0.0, 3.0);
  require_range("num_threads", num_threads, 1, 256);
  require_range("num_surface_vertices", num_surface_vertices, 300, 4000);
  make_schedule(schedule, duration_s, seed);  // names an unknown schedule
}

struct Performer::Impl {
  Impl(const PerformerOptions& performer_options, std::shared_ptr<const Anatomy> person)
      : options(performer_options),
        anatomy(std::move(person)),
        simulator(anatomy),
        renderer(anatomy, render_options(performer_options)),
        schedule(make_schedule(options.schedule, options.duration_s, options.seed)),
        sway(options.seed, options.sway),
        upright(frame_the_face(*anatomy, options.width_px, options.height_px)),
        state(simulator.rest()),
        muscles(anatomy->muscle_names()) {
    controls.contraction.assign(muscles.size(), 0.0);
    num_frames =
        std::max(1, static_cast<int>(std::lround(options.duration_s * options.frames_per_s)));
  }

  static RenderOptions render_options(const PerformerOptions& options) {
    RenderOptions render;
    render.num_threads = options.num_threads;
    render.lighting = draw_lighting(options.seed);
    return render;
  }

  Contractions act(double time_s);
  Camera camera_at(double time_s) const;

  PerformerOptions options;
  std::shared_ptr<const Anatomy> anatomy;
  Simulator simulator;
  Renderer renderer;
  Schedule schedule;
  Sway sway;
  Camera upright;
  FaceState state;
  Controls controls;
  std::vector<std::string> muscles;
  std::vector<Vec3> skin_mm;
  ContourSet first_at_rest;  // resting face in the pose of frame 0
  int num_frames = 0;
  int next_frame = 0;
};

// Settles the face for an instant and says what it was told.
Contractions Performer::Impl::act(double time_s) {
  Contractions truth;
  truth.frame_index = next_frame;
  truth.time_s = time_s;
  truth.confidence = 1.0;
  truth.success = true;
  truth.jaw = schedule.value_at("", time_s);
  for (std::size_t i = 0; i < muscles.size(); ++i) {
    truth.value.push_back(schedule.value_at(muscles[i], time_s));
  }
  const double jaw_rad = truth.jaw * anatomy->jaw.full_rad;
  if (controls.contraction != truth.value || controls.jaw_rad != jaw_rad) {
    controls.contraction = truth.value;
    controls.jaw_rad = jaw_rad;
    // Rest is known exactly; a settle would stop a tolerance short of it.
    const bool at_rest =
        jaw_rad == 0.0 &&
        std::all_of(truth.value.begin(), truth.value.end(), [](double c) { return c == 0.0; });
    if (at_rest) {
      state = simulator.rest();
    } else {
      simulator.settle(controls, state);
    }
  }
  embed_skin(*anatomy, state, skin_mm);
  return truth;
}

Camera Performer::Impl::camera_at(double time_s) const {
  Camera camera = upright;
  camera.camera_from_face = upright.camera_from_face * sway.head_at(time_s);
  return camera;
}

Performer::Performer(const PerformerOptions& options) {
  options.check();
  HeadOptions head;
  head.num_surface_vertices = options.num_surface_vertices;
  impl_ = std::make_unique<Impl>(
      options,
      std::make_shared<const Anatomy>(make_generic_head(draw_identity(options.seed), head)));
}

Performer::~Performer() = default;

int Performer::num_frames() const { return impl_->num_frames; }

const std::vector<std::string>& Performer::muscles() const { return impl_->muscles; }

bool Performer::next(Frame& frame, Contractions& truth, ContourSet& true_contours) {
  Impl& impl = *impl_;
  if (impl.next_frame >= impl.num_frames) return false;
  const double time_s = impl.next_frame / impl.options.frames_per_s;
  truth = impl.act(time_s);
  const Camera camera = impl.camera_at(time_s);

  true_contours = project_contours(*impl.anatomy, impl.skin_mm, camera);
  true_contours.frame_index = impl.next_frame;
  true_contours.time_s = time_s;
  const ContourSet at_rest =
      project_contours(*impl.anatomy, impl.anatomy->skin.mesh.positions_mm, camera);
  if (impl.next_frame == 0) impl.first_at_rest = at_rest;
  truth.head = true_pose(impl.first_at_rest, at_rest);

  frame.index = impl.next_frame;
  frame.time_s = time_s;
  cv::Mat picture;  // a fresh one: the caller may keep the last frame
  impl.renderer.render(impl.skin_mm, impl.state.jaw_rad, camera, picture);
  add_noise(picture, impl.options.noise_grey_levels, impl.options.seed, impl.next_frame);
  frame.image = picture;
  ++impl.next_frame;
  return true;
}

}  // namespace zygoma
