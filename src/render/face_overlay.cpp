#include "src/render/face_overlay.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "src/base/names.h"

namespace zygoma {
namespace {

const std::vector<std::string> kNames{"none", "lattice", "muscles", "volume", "strain"};

constexpr double kFullVolume = 0.30;  // where false colour is full
constexpr double kFullStrain = 0.40;

// Blue - pale - red, linear RGB, for t in [-1, 1]; opacity grows with |t|.
Eigen::Vector4f false_colour(double t) {
  t = std::clamp(t, -1.0, 1.0);
  const auto size = static_cast<float>(std::abs(t));
  const Eigen::Vector3f pale(0.62F, 0.60F, 0.58F);
  const Eigen::Vector3f full =
      t < 0.0 ? Eigen::Vector3f(0.01F, 0.06F, 0.55F) : Eigen::Vector3f(0.60F, 0.015F, 0.015F);
  const Eigen::Vector3f colour = pale + std::sqrt(size) * (full - pale);
  return {colour.x(), colour.y(), colour.z(), 0.45F + 0.50F * std::min(1.0F, 2.0F * size)};
}

cv::Scalar bgr_of(const Eigen::Vector4f& linear) {
  cv::Scalar bgr;
  for (int k = 0; k < 3; ++k) bgr[k] = 255.0 * std::pow(static_cast<double>(linear[2 - k]), 0.4545);
  return bgr;
}

// 2 x 2 coordinates of a triangle's edges in its own plane.
Eigen::Matrix2d flat_edges(const std::vector<Vec3>& at, const Triangle& t) {
  const Vec3 ab = at[t[1]] - at[t[0]];
  const Vec3 ac = at[t[2]] - at[t[0]];
  const double length = std::max(1e-9, ab.norm());
  Eigen::Matrix2d flat;
  flat << length, ab.dot(ac) / length, 0.0, ab.cross(ac).norm() / length;
  return flat;
}

cv::Point pixel(const Camera& camera, const Vec3& at) {
  constexpr int kSubpixels = 16;  // of cv::line with shift 4
  const Vec2 p = camera.project(at);
  return {static_cast<int>(std::lround(kSubpixels * p.x())),
          static_cast<int>(std::lround(kSubpixels * p.y()))};
}

bool faces(const Camera& camera, const std::vector<Vec3>& at, const Triangle& t) {
  const Vec3 normal = (at[t[1]] - at[t[0]]).cross(at[t[2]] - at[t[0]]);
  const Vec3 eye = camera.camera_from_face.inverse().translation();
  return normal.dot(eye - at[t[0]]) > 0.0;
}

int nearest_vertex(const SurfaceMesh& surface, const Vec3& p) {
  const std::vector<Vec3>& at = surface.positions_mm;
  const auto nearer = [&](const Vec3& a, const Vec3& b) {
    return (a - p).squaredNorm() < (b - p).squaredNorm();
  };
  return static_cast<int>(std::min_element(at.begin(), at.end(), nearer) - at.begin());
}

std::vector<CoursePoint> course_of(const Muscle& muscle, const SurfaceMesh& surface) {
  const auto beside = [&](const Vec3& p) {
    const int v = nearest_vertex(surface, p);
    return CoursePoint{v, p - surface.positions_mm[v], false};
  };
  if (!muscle.ring) return {beside(muscle.attachment_mm)};
  // Half way between hole and edge of the ellipse.
  constexpr int kSteps = 40;
  constexpr double kShare = 0.65;
  const Vec3 along = kShare * (muscle.emergence_mm - muscle.attachment_mm);
  Vec3 across = muscle.ring->aspect * muscle.ring->forward.cross(along);
  if (across.y() < 0.0) across = -across;
  std::vector<CoursePoint> course;
  bool joined = false;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = 2.0 * M_PI * (i + 0.5) / kSteps;
    const Vec3 p = muscle.attachment_mm + std::cos(angle) * along + std::sin(angle) * across;
    const bool part =
        muscle.ring->side * p.x() >= 0.0 && muscle.ring->flap * std::sin(angle) >= 0.0;
    if (part) {
      course.push_back(beside(p));
      course.back().beside_mm.z() = 0.0;  // a ring is flat, the skin is not
      course.back().joined = joined;
    }
    joined = part;
  }
  return course;
}

}  // namespace

Overlay parse_overlay(const std::string& text) {
  return static_cast<Overlay>(require_name("overlay", kNames, text));
}

const std::vector<std::string>& overlay_names() { return kNames; }

std::vector<double> volume_change(const Lattice& lattice, const std::vector<Vec3>& positions_mm) {
  std::vector<double> rest(lattice.num_vertices, 0.0);
  std::vector<double> now(lattice.num_vertices, 0.0);
  for (const Prism& prism : lattice.prisms) {
    const double volume = signed_volume(prism, positions_mm);
    for (const int node : prism.node) {
      for (const int v : lattice.columns[lattice.column_of[node]].vertex) {
        rest[v] += prism.rest_mm3;
        now[v] += volume;
      }
    }
  }
  for (int v = 0; v < lattice.num_vertices; ++v) {
    now[v] = rest[v] > 0.0 ? now[v] / rest[v] - 1.0 : 0.0;
  }
  return now;
}

std::vector<double> skin_strain(const SurfaceMesh& rest, const std::vector<Vec3>& positions_mm) {
  std::vector<double> sum(rest.positions_mm.size(), 0.0);
  std::vector<double> area(rest.positions_mm.size(), 0.0);
  for (const Triangle& t : rest.triangles) {
    const Eigen::Matrix2d before = flat_edges(rest.positions_mm, t);
    const Eigen::Matrix2d stretch = flat_edges(positions_mm, t) * before.inverse();
    const Eigen::Vector2d principal = stretch.jacobiSvd().singularValues().array() - 1.0;
    const double largest =
        std::abs(principal[0]) > std::abs(principal[1]) ? principal[0] : principal[1];
    for (const int v : t) {
      sum[v] += before.determinant() * largest;
      area[v] += before.determinant();
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = area[v] > 0.0 ? sum[v] / area[v] : 0.0;
  return sum;
}

FaceOverlay::FaceOverlay(Overlay overlay, const Anatomy& anatomy, const Lattice& lattice)
    : overlay_(overlay), anatomy_(anatomy), lattice_(lattice) {
  for (const Muscle& muscle : anatomy_.muscles)
    course_.push_back(course_of(muscle, anatomy_.surface));
}

const SkinTint* FaceOverlay::tint(const FaceState& state) {
  if (overlay_ != Overlay::kVolume && overlay_ != Overlay::kStrain) return nullptr;
  const bool strain = overlay_ == Overlay::kStrain;
  const std::vector<double> field = strain ? skin_strain(anatomy_.surface, state.positions_mm)
                                           : volume_change(lattice_, state.positions_mm);
  const double full = strain ? kFullStrain : kFullVolume;
  const Embedding& embedding = anatomy_.skin.embedding;
  tint_.resize(anatomy_.skin.mesh.positions_mm.size());
  for (std::size_t v = 0; v < tint_.size(); ++v) {
    double value = 0.0;
    for (int k = embedding.begin[v]; k < embedding.begin[v + 1]; ++k) {
      value += static_cast<double>(embedding.weight[k]) * field[embedding.index[k]];
    }
    tint_[v] = false_colour(value / full);
  }
  return &tint_;
}

void FaceOverlay::draw(const Controls& controls,
                       const FaceState& state,
                       const Camera& camera,
                       cv::Mat& bgr) const {
  switch (overlay_) {
    case Overlay::kNone:
      return;
    case Overlay::kLattice:
      return draw_lattice(state, camera, bgr);
    case Overlay::kMuscles:
      return draw_muscles(controls, state, camera, bgr);
    case Overlay::kVolume:
    case Overlay::kStrain:
      return draw_bar(bgr);
  }
}

void FaceOverlay::draw_lattice(const FaceState& state, const Camera& camera, cv::Mat& bgr) const {
  cv::Mat lines = bgr.clone();
  const int thickness = std::max(1, bgr.rows / 800);
  for (const Triangle& t : anatomy_.surface.triangles) {
    if (!faces(camera, state.positions_mm, t)) continue;
    for (int k = 0; k < 3; ++k) {
      cv::line(lines,
               pixel(camera, state.positions_mm[t[k]]),
               pixel(camera, state.positions_mm[t[(k + 1) % 3]]),
               cv::Scalar(255, 245, 225),
               thickness,
               cv::LINE_AA,
               4);
    }
  }
  cv::addWeighted(lines, 0.55, bgr, 0.45, 0.0, bgr);
}

void FaceOverlay::draw_muscles(const Controls& controls,
                               const FaceState& state,
                               const Camera& camera,
                               cv::Mat& bgr) const {
  const Vec3 eye = camera.camera_from_face.inverse().translation();
  const std::vector<Vec3> normals = smooth_normals(anatomy_.surface, lattice_.neighbors, 1);
  for (std::size_t m = 0; m < anatomy_.muscles.size(); ++m) {
    const Muscle& muscle = anatomy_.muscles[m];
    const std::vector<CoursePoint>& course = course_[m];
    const double c = m < controls.contraction.size() ? controls.contraction[m] : 0.0;
    const cv::Scalar dark(25, 20, 45);
    const cv::Scalar colour(175.0 - 150.0 * c, 185.0 - 165.0 * c, 215.0 + 10.0 * c);
    const double scale = bgr.rows / 480.0;
    const int thickness = std::max(1, static_cast<int>(std::lround(scale * (1.2 + 3.0 * c))));
    const auto stretch = [&](const Vec3& from, const Vec3& to) {
      const int rim = thickness + std::max(1, thickness / 2);
      cv::line(bgr, pixel(camera, from), pixel(camera, to), dark, rim, cv::LINE_AA, 4);
      cv::line(bgr, pixel(camera, from), pixel(camera, to), colour, thickness, cv::LINE_AA, 4);
    };
    const auto place = [&](const CoursePoint& p) -> Vec3 {
      return state.positions_mm[p.vertex] + p.beside_mm;
    };
    const auto is_seen = [&](const CoursePoint& p) {
      return normals[p.vertex].dot(eye - place(p)) > 0.0;
    };
    if (muscle.ring) {
      for (std::size_t k = 0; k + 1 < course.size(); ++k) {
        if (!course[k + 1].joined || !is_seen(course[k]) || !is_seen(course[k + 1])) continue;
        stretch(place(course[k]), place(course[k + 1]));
      }
      continue;
    }
    if (!is_seen(course.front())) continue;
    const Vec3 end = place(course.front());
    stretch(muscle.emergence_mm, end);
    const int dot = static_cast<int>(std::lround(16.0 * scale * (1.8 + 1.2 * c)));
    cv::circle(bgr, pixel(camera, end), dot, colour, cv::FILLED, cv::LINE_AA, 4);
    cv::circle(
        bgr, pixel(camera, muscle.emergence_mm), dot * 2 / 3, dark, cv::FILLED, cv::LINE_AA, 4);
  }
}

void FaceOverlay::draw_bar(cv::Mat& bgr) const {
  const bool strain = overlay_ == Overlay::kStrain;
  const double scale = bgr.rows / 480.0;
  const cv::Rect bar(cv::Point(bgr.cols - static_cast<int>(28 * scale), bgr.rows / 4),
                     cv::Size(static_cast<int>(12 * scale), bgr.rows / 2));
  for (int row = 0; row < bar.height; ++row) {
    const double t = 1.0 - 2.0 * row / (bar.height - 1.0);
    cv::line(bgr, {bar.x, bar.y + row}, {bar.br().x, bar.y + row}, bgr_of(false_colour(t)));
  }
  cv::rectangle(bgr, bar, cv::Scalar::all(230), 1);
  const double full = 100.0 * (strain ? kFullStrain : kFullVolume);
  const auto write = [&](const std::string& text, int y) {
    int baseline = 0;
    const double size = 0.36 * scale;
    const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline);
    const cv::Point at(bar.br().x - box.width, y + box.height / 2);
    cv::putText(
        bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar::all(240), 1, cv::LINE_AA);
  };
  const int gap = static_cast<int>(11 * scale);
  const std::string percent = std::to_string(static_cast<int>(std::lround(full))) + " %";
  write("+" + percent, bar.y - gap);
  write(strain ? "strain" : "volume", bar.y - 2 * gap - gap / 2);
  write("-" + percent, bar.br().y + gap);
}

}  // namespace zygoma
