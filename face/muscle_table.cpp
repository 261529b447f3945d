#include "face/muscle_table.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "src/base/check.h"

namespace zygoma {
namespace {

struct TableRow {
  const char* name;
  double attachment_xy_mm[2];  // skin end
  double emergence_xy_mm[2];   // bone end
  double radius_mm;            // influence along the skin
  double pull_mm;              // displacement asked for at contraction 1
};

constexpr std::array<TableRow, 9> kTable{{
    {"zygomaticus_major", {28.0, -77.0}, {60.0, -36.0}, 30.0, 14.0},
    {"levator_labii_superioris_alaeque_nasi", {16.0, -43.0}, {10.0, -10.0}, 18.0, 8.0},
    {"levator_labii_superioris", {18.0, -66.0}, {23.0, -17.0}, 22.0, 9.0},
    {"occipitofrontalis_inner", {11.0, 17.0}, {9.0, 56.0}, 24.0, 10.0},
    {"occipitofrontalis_major", {34.0, 18.0}, {34.0, 58.0}, 26.0, 10.0},
    {"occipitofrontalis_outer", {53.0, 20.0}, {56.0, 50.0}, 23.0, 9.0},
    {"corrugator_supercilii", {20.0, 18.0}, {4.0, 6.0}, 20.0, 7.0},
    {"depressor_anguli_oris", {28.0, -79.0}, {33.0, -104.0}, 30.0, 9.0},
    {"depressor_labii_inferioris", {12.0, -85.0}, {17.0, -106.0}, 18.0, 7.0},
}};

constexpr double kBoneDepthMm = 6.0;  // of the bone end below the skin

Vec3 triangle_normal(const SurfaceMesh& surface, const Triangle& t) {
  const Vec3& a = surface.positions_mm[t[0]];
  return (surface.positions_mm[t[1]] - a).cross(surface.positions_mm[t[2]] - a);
}

struct SurfacePoint {
  Vec3 position_mm;
  Vec3 normal;
};

// Barycentric coordinates of p in the frontal projection of a triangle; false if the triangle is
// seen from behind or edge-on.
bool frontal_barycentric(const SurfaceMesh& surface, const Triangle& t, const Vec2& p, Vec3& w) {
  const Vec2 a = surface.positions_mm[t[0]].head<2>();
  const Vec2 ab = surface.positions_mm[t[1]].head<2>() - a;
  const Vec2 ac = surface.positions_mm[t[2]].head<2>() - a;
  const double area = ab.x() * ac.y() - ab.y() * ac.x();
  if (area < 1e-9) return false;
  const Vec2 ap = p - a;
  w[1] = (ap.x() * ac.y() - ap.y() * ac.x()) / area;
  w[2] = (ab.x() * ap.y() - ab.y() * ap.x()) / area;
  w[0] = 1.0 - w[1] - w[2];
  return true;
}

// The surface point seen at p from the front; in a hole (mouth, eye) or beside the face the nearest
// point of a triangle that faces forward.
SurfacePoint frontal_point(const SurfaceMesh& surface, const Vec2& p) {
  SurfacePoint best;
  double best_distance = std::numeric_limits<double>::infinity();
  double best_z = -std::numeric_limits<double>::infinity();
  for (const Triangle& t : surface.triangles) {
    Vec3 w;
    if (!frontal_barycentric(surface, t, p, w)) continue;
    // Outside, the clamped weights give a point of the triangle close to the nearest one.
    w = w.cwiseMax(0.0);
    w /= w.sum();
    const Vec3 q = w[0] * surface.positions_mm[t[0]] + w[1] * surface.positions_mm[t[1]] +
                   w[2] * surface.positions_mm[t[2]];
    const double distance = (q.head<2>() - p).norm();
    const bool nearer = distance < best_distance - 1e-9;
    const bool in_front = distance < best_distance + 1e-9 && q.z() > best_z;
    if (!nearer && !in_front) continue;
    best_distance = std::min(distance, best_distance);
    best_z = q.z();
    best = {q, triangle_normal(surface, t).normalized()};
  }
  require(std::isfinite(best_distance), "surface: no triangle faces forward, expected a face");
  return best;
}

// Mean scale of the map around a canonical point.
double scale_at(const std::function<Vec2(Vec2)>& map, const Vec2& p) {
  constexpr double kStepMm = 5.0;
  const double x = (map(p + Vec2(kStepMm, 0.0)) - map(p - Vec2(kStepMm, 0.0))).norm();
  const double y = (map(p + Vec2(0.0, kStepMm)) - map(p - Vec2(0.0, kStepMm))).norm();
  return 0.5 * (x + y) / (2.0 * kStepMm);
}

}  // namespace

std::vector<Muscle> standard_muscles(const SurfaceMesh& surface,
                                     const std::function<Vec2(Vec2)>& head_xy_from_canonical_xy) {
  std::vector<Muscle> muscles;
  for (const TableRow& row : kTable) {
    for (const double side : {1.0, -1.0}) {
      const Vec2 attachment(side * row.attachment_xy_mm[0], row.attachment_xy_mm[1]);
      const Vec2 emergence(side * row.emergence_xy_mm[0], row.emergence_xy_mm[1]);
      const SurfacePoint bone = frontal_point(surface, head_xy_from_canonical_xy(emergence));
      Muscle muscle;
      muscle.name = std::string(row.name) + (side > 0.0 ? "_L" : "_R");
      muscle.attachment_mm =
          frontal_point(surface, head_xy_from_canonical_xy(attachment)).position_mm;
      muscle.emergence_mm = bone.position_mm - kBoneDepthMm * bone.normal;
      const double scale = scale_at(head_xy_from_canonical_xy, attachment);
      muscle.radius_mm = row.radius_mm * scale;
      muscle.largest_shortening =
          row.pull_mm * scale / (muscle.emergence_mm - muscle.attachment_mm).norm();
      muscles.push_back(std::move(muscle));
    }
  }
  return muscles;
}

std::vector<std::string> standard_muscle_names() {
  std::vector<std::string> names;
  for (const TableRow& row : kTable) {
    for (const char* side : {"_L", "_R"}) names.push_back(std::string(row.name) + side);
  }
  return names;
}

}  // namespace zygoma
