#include "face/muscle_table.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "src/base/names.h"

namespace zygoma {
namespace {

struct TableRow {
  const char* name;
  double attachment_xy_mm[2];  // skin end
  double emergence_xy_mm[2];   // bone end
  double radius_mm;            // influence along the skin
  double pull_mm;              // displacement asked for at contraction 1
  double scalp_share = 0.0;    // of it, by which the other end comes down
};

constexpr std::array<TableRow, 21> kTable{{
    {"zygomaticus_major", {28.0, -77.0}, {60.0, -36.0}, 30.0, 14.0},
    {"levator_labii_superioris_alaeque_nasi", {18.0, -45.0}, {12.0, -10.0}, 26.0, 9.5},
    {"levator_labii_superioris", {18.0, -66.0}, {23.0, -17.0}, 22.0, 9.0},
    {"occipitofrontalis_inner", {11.0, 17.0}, {13.0, 78.0}, 26.0, 10.0, 0.4},
    {"occipitofrontalis_major", {34.0, 18.0}, {36.0, 76.0}, 26.0, 10.0, 0.3},
    {"occipitofrontalis_outer", {53.0, 20.0}, {57.0, 58.0}, 23.0, 9.0, 0.2},
    {"corrugator_supercilii", {20.0, 18.0}, {4.0, 6.0}, 20.0, 7.0},
    {"depressor_anguli_oris", {28.0, -79.0}, {33.0, -104.0}, 30.0, 9.0},
    {"depressor_labii_inferioris", {12.0, -85.0}, {17.0, -106.0}, 18.0, 7.0},
    {"zygomaticus_minor", {20.0, -68.0}, {48.0, -28.0}, 22.0, 8.0},
    {"levator_anguli_oris", {27.0, -75.0}, {21.0, -36.0}, 22.0, 8.0},
    {"risorius", {29.0, -77.0}, {66.0, -72.0}, 28.0, 10.0},
    {"buccinator", {30.0, -76.0}, {58.0, -70.0}, 18.0, 6.0},
    {"mentalis", {10.0, -116.0}, {7.0, -92.0}, 24.0, 4.5},
    {"platysma", {32.0, -92.0}, {50.0, -146.0}, 34.0, 9.0},
    {"incisivus_labii_superioris", {24.0, -73.0}, {7.0, -64.0}, 22.0, 7.0},
    {"incisivus_labii_inferioris", {24.0, -80.0}, {7.0, -90.0}, 22.0, 7.0},
    {"procerus", {5.0, 18.0}, {3.0, -10.0}, 20.0, 4.5},
    {"depressor_supercilii", {13.0, 16.0}, {9.0, 0.0}, 16.0, 5.0},
    {"nasalis_alar", {16.0, -46.0}, {24.0, -56.0}, 10.0, 3.0},
    {"nasalis_transverse", {15.0, -40.0}, {2.0, -30.0}, 11.0, 3.0},
}};

// Rings, in the plane of the picture. Those around the mouth come in quarters.
struct RingRow {
  const char* name;
  double centre_xy_mm[2];
  double end_xy_mm[2];  // of the half axis along the slit
  double aspect, hole, rim;
  double shortening;  // s
  double along, across;
  double forward_mm;
  int flap;         // +1 upper, -1 lower, 0 both
  bool around_eye;  // else around the mouth, a half on each side
};

// clang-format off
constexpr std::array<RingRow, 7> kRings{{
    // The peripheral part purses: the corners come in, the lips forward, and swell up and down.
    {"orbicularis_oris_superior",
     {0, -76.5}, {46, -77}, 0.62, 0, 0.3, 0.36, 1.0, -0.35, 5.0, +1, false},
    {"orbicularis_oris_inferior",
     {0, -76.5}, {46, -77}, 0.62, 0, 0.3, 0.36, 1.0, -0.35, 5.0, -1, false},
    // The marginal part, in the red of the lips, makes them thin and presses them to the teeth.
    {"orbicularis_oris_marginal_superior",
     {0, -76.5}, {38, -77}, 0.5, 0, 0.4, 0.32, 0.2, 0.8, -2.0, +1, false},
    {"orbicularis_oris_marginal_inferior",
     {0, -76.5}, {38, -77}, 0.5, 0, 0.4, 0.32, 0.2, 0.8, -2.0, -1, false},
    {"orbicularis_oculi_orbital",
     {31.5, -3}, {70, -2}, 0.9, 0.2, 0.45, 0.3, 0.5, 1.0, 0, 0, true},
    {"orbicularis_oculi_palpebral",
     {31.5, -2.8}, {52, -1.4}, 0.9, 0, 0.4, 0.98, 0, 1.0, 0, 0, true},
    {"levator_palpebrae_superioris",
     {31.5, -2.8}, {52, -1.4}, 0.9, 0, 0.4, 0.35, 0, -1.0, 0, +1, true},
}};
// clang-format on

constexpr double kEyeBehindLids_mm = 17.0;  // centre of the eyeball, below the height of the lids
constexpr double kLidAt_mm = 7.0;           // above the centre of the eye

constexpr double kBoneDepthMm = 6.0;  // of the bone end below the skin

Vec3 triangle_normal(const SurfaceMesh& surface, const Triangle& t) {
  const Vec3& a = surface.positions_mm[t[0]];
  return (surface.positions_mm[t[1]] - a).cross(surface.positions_mm[t[2]] - a);
}

struct SurfacePoint {
  Vec3 position_mm;
  Vec3 normal;
};

// Barycentric coordinates of the point of a triangle that is nearest to p in the frontal
// projection; false if the triangle is seen from behind or edge-on.
bool frontal_nearest(const SurfaceMesh& surface, const Triangle& t, const Vec2& p, Vec3& w) {
  const std::array<Vec2, 3> x{surface.positions_mm[t[0]].head<2>(),
                              surface.positions_mm[t[1]].head<2>(),
                              surface.positions_mm[t[2]].head<2>()};
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  const double area = cross(x[1] - x[0], x[2] - x[0]);
  if (area < 1e-9) return false;
  for (int k = 0; k < 3; ++k) {
    w[k] = cross(x[(k + 1) % 3] - p, x[(k + 2) % 3] - p) / area;
  }
  if (w.minCoeff() >= 0.0) return true;
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec2 along = x[(k + 1) % 3] - x[k];
    const double u = std::clamp((p - x[k]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const double distance = (x[k] + u * along - p).norm();
    if (distance >= best) continue;
    best = distance;
    w.setZero();
    w[k] = 1.0 - u;
    w[(k + 1) % 3] = u;
  }
  return true;
}

// The surface point seen at p from the front; in a hole (mouth, eye) or beside the face the nearest
// one that is seen. On an edge the normal is the mean of its sides, so that it does not depend on
// the order of the triangles.
SurfacePoint frontal_point(const SurfaceMesh& surface, const Vec2& p) {
  constexpr double kSameMm = 1e-6;
  SurfacePoint best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const Triangle& t : surface.triangles) {
    Vec3 w;
    if (!frontal_nearest(surface, t, p, w)) continue;
    const Vec3 q = w[0] * surface.positions_mm[t[0]] + w[1] * surface.positions_mm[t[1]] +
                   w[2] * surface.positions_mm[t[2]];
    const double distance = (q.head<2>() - p).norm();
    if (distance > best_distance + kSameMm) continue;
    const bool nearer = distance < best_distance - kSameMm;
    if (!nearer && q.z() < best.position_mm.z() - kSameMm) continue;
    const Vec3 normal = triangle_normal(surface, t).normalized();
    if (!nearer && (q - best.position_mm).norm() < kSameMm) {
      best.normal += normal;
    } else {
      best_distance = distance;
      best = {q, normal};
    }
  }
  require(std::isfinite(best_distance), "surface: no triangle faces forward, expected a face");
  best.normal.normalize();
  return best;
}

// Mean scale of the map around a canonical point.
double scale_at(const std::function<Vec2(Vec2)>& map, const Vec2& p) {
  constexpr double kStepMm = 5.0;
  const double x = (map(p + Vec2(kStepMm, 0.0)) - map(p - Vec2(kStepMm, 0.0))).norm();
  const double y = (map(p + Vec2(0.0, kStepMm)) - map(p - Vec2(0.0, kStepMm))).norm();
  return 0.5 * (x + y) / (2.0 * kStepMm);
}

const char* suffix(double side) { return side > 0.0 ? "_L" : "_R"; }

Muscle fibre_from(const TableRow& row,
                  double side,
                  const SurfaceMesh& surface,
                  const std::function<Vec2(Vec2)>& map) {
  const Vec2 attachment(side * row.attachment_xy_mm[0], row.attachment_xy_mm[1]);
  const Vec2 emergence(side * row.emergence_xy_mm[0], row.emergence_xy_mm[1]);
  const SurfacePoint bone = frontal_point(surface, map(emergence));
  Muscle muscle;
  muscle.name = std::string(row.name) + suffix(side);
  muscle.attachment_mm = frontal_point(surface, map(attachment)).position_mm;
  muscle.emergence_mm = bone.position_mm - kBoneDepthMm * bone.normal;
  const double scale = scale_at(map, attachment);
  muscle.radius_mm = row.radius_mm * scale;
  muscle.largest_shortening =
      row.pull_mm * scale / (muscle.emergence_mm - muscle.attachment_mm).norm();
  muscle.scalp_share = row.scalp_share;
  return muscle;
}

Muscle ring_from(const RingRow& row,
                 double side,
                 const SurfaceMesh& surface,
                 const std::function<Vec2(Vec2)>& map) {
  const Vec2 centre = map({side * row.centre_xy_mm[0], row.centre_xy_mm[1]});
  const Vec2 end = map({side * row.end_xy_mm[0], row.end_xy_mm[1]});
  // The hole of the eye has no depth of its own: that of the lid above.
  const Vec2 lid = map({side * row.centre_xy_mm[0], row.centre_xy_mm[1] + kLidAt_mm});
  const double z = frontal_point(surface, row.around_eye ? lid : centre).position_mm.z();
  Muscle muscle;
  muscle.name = std::string(row.name) + suffix(side);
  muscle.attachment_mm = {centre.x(), centre.y(), z};
  muscle.emergence_mm = {end.x(), end.y(), z};
  muscle.radius_mm = (end - centre).norm();
  muscle.largest_shortening = row.shortening;
  Ring& ring = muscle.ring.emplace();
  ring.aspect = row.aspect;
  ring.hole = row.hole;
  ring.rim = row.rim;
  ring.along = row.along;
  ring.across = row.across;
  ring.forward_mm = row.forward_mm;
  ring.flap = row.flap;
  if (row.around_eye) {
    ring.pivot_mm = muscle.attachment_mm - kEyeBehindLids_mm * Vec3::UnitZ();
  } else {
    ring.side = side > 0.0 ? 1 : -1;
  }
  return muscle;
}

}  // namespace

std::vector<Muscle> standard_muscles(const SurfaceMesh& surface,
                                     const std::function<Vec2(Vec2)>& head_xy_from_canonical_xy) {
  std::vector<Muscle> muscles;
  for (const TableRow& row : kTable) {
    for (const double side : {1.0, -1.0}) {
      muscles.push_back(fibre_from(row, side, surface, head_xy_from_canonical_xy));
    }
  }
  for (const RingRow& row : kRings) {
    for (const double side : {1.0, -1.0}) {
      muscles.push_back(ring_from(row, side, surface, head_xy_from_canonical_xy));
    }
  }
  return muscles;
}

std::vector<std::string> standard_muscle_names() {
  std::vector<std::string> names;
  const auto add = [&](const auto& table) {
    for (const auto& row : table) {
      for (const double side : {1.0, -1.0}) names.push_back(std::string(row.name) + suffix(side));
    }
  };
  add(kTable);
  add(kRings);
  return names;
}

std::vector<std::string> muscles_meant(const std::string& where, const std::string& name) {
  const std::vector<std::string> known = standard_muscle_names();
  if (find_name(known, name + "_L") >= 0) return {name + "_L", name + "_R"};
  if (find_name(known, name) >= 0) return {name};
  std::vector<std::string_view> pairs;
  for (const std::string& muscle : known) {
    if (muscle.ends_with("_L")) pairs.push_back(without_side(muscle));
  }
  throw InputError(where + "muscle " + quote_value(name) + " is unknown, expected one of " +
                   joined_names(pairs) + ", for one side with _L or _R");
}

}  // namespace zygoma
