#include "face/generic_head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "face/appearance.h"
#include "face/head_mesh.h"
#include "face/head_parts.h"
#include "face/head_relief.h"
#include "face/head_shape.h"
#include "face/head_skin.h"
#include "face/muscle_table.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

void require_colour(const std::string& name, const Eigen::Vector3f& colour) {
  for (int k = 0; k < 3; ++k) require_range(name, static_cast<double>(colour[k]), 0.0, 1.0);
}

// Thickness of the soft tissue at places of the frontal picture, x >= 0, millimetres: forensic
// averages, rounded.
struct TissueSample {
  double x, y, depth_mm;
};
constexpr std::array<TissueSample, 24> kTissue{{
    {0, 65, 4.2},   {30, 65, 4.2},   {0, 35, 4.8},    {30, 38, 5.0},   {60, 35, 5.0},
    {0, 8, 5.5},    {0, -12, 2.6},   {0, -34, 4.5},   {12, -42, 6.0},  {14, -10, 4.5},
    {31, 22, 6.0},  {31, 6, 3.0},    {31, -14, 5.0},  {31, -30, 9.0},  {52, -25, 9.0},
    {68, -20, 7.0}, {42, -50, 14.0}, {60, -60, 13.0}, {0, -55, 9.5},   {25, -66, 9.5},
    {0, -69, 8.0},  {0, -88, 9.5},   {0, -104, 9.0},  {45, -90, 10.0},
}};

double tissue_depth(const HeadShape& shape, const DomainPoint& point, const Vec2& front) {
  if (point.inward > 0.0) return 1.2;
  const Vec2 at(std::abs(front.x()), front.y());
  double sum = 0.0;
  double total = 0.0;
  for (const TissueSample& s : kTissue) {
    const double d = (at - Vec2(s.x, s.y)).norm();
    const double w = 1.0 / std::pow(d + 4.0, 3.0);
    sum += w * s.depth_mm;
    total += w;
  }
  double depth = sum / total;
  // The lips are as thick as their free edge where they part, and gain from there.
  const double off_corner = std::abs(point.at_mm.x()) - shape.mouth_corner_x();
  const double along_slit = std::min(std::abs(point.at_mm.x()), shape.mouth_corner_x());
  const double off_line = point.at_mm.y() - shape.mouth_rim(along_slit, 0);
  const double from_slit = std::hypot(std::max(0.0, off_corner), off_line);
  depth = 3.2 + (depth - 3.2) * smooth_step(0.0, 11.0, from_slit);
  if (point.rim == Rim::kEye) depth = 1.4;  // thin: a lid goes where its muscle takes it
  // Thinner towards the outline of the head.
  const double x = std::abs(point.at_mm.x());
  const double border = std::min({172.0 - x, point.at_mm.y() + 172.0, 203.0 - point.at_mm.y()});
  return std::max(1.2, depth * (0.4 + 0.6 * smooth_step(0.0, 45.0, border)));
}

// 1 on everything the mandible carries, 0 on the skull. The cheek blends along the line from the
// corner of the mouth to the ear. The lips part at the slit, but towards its corner both come to
// share the motion (what lies behind them there is the cheek, not a bone), so that no column of
// tissue stands between two neighbours which the jaw tears apart.
double mandible_weight(const HeadShape& shape, const DomainPoint& point) {
  constexpr double kCornerHalfWidth = 11.0;
  const double x = std::abs(point.at_mm.x());
  const double y = point.at_mm.y();
  const double corner = shape.mouth_corner_x();
  const double neck = smooth_step(-165.0, -125.0, y);
  const double back = smooth_step(122.0, 96.0, x);
  const double rise = std::clamp(x - corner, 0.0, 60.0);
  const double line = shape.mouth_rim(std::min(x, corner), 0) + 0.42 * rise;
  const double half_width = kCornerHalfWidth + 0.5 * rise;
  const double blended = smooth_step(half_width, -half_width, y - line);
  const bool below = point.rim == Rim::kMouth ? point.side < 0 : y < line;
  // The lower lip stretches towards the upper one and lags behind the teeth.
  const double lag = 0.1 * smooth_step(-90.0, -70.0, y);
  const double parted = below ? 1.0 - lag : 0.0;
  const double shared = std::pow(std::min(1.0, x / corner), 2.5);
  return (parted + shared * (blended - parted)) * neck * back;
}

Region region_of(const HeadShape& shape, const DomainPoint& point, const Vec2& front) {
  static const FunctionCurve upper(upper_lip_border());
  static const FunctionCurve lower(lower_lip_border());
  const double x = std::abs(front.x());
  if (point.rim == Rim::kMouth) return point.side < 0 ? Region::kLowerLip : Region::kUpperLip;
  if (point.rim == Rim::kEye) return point.side < 0 ? Region::kLowerLid : Region::kUpperLid;
  if (x < 26.0) {
    const double middle = shape.mouth_rim(std::abs(point.at_mm.x()), 0);
    if (front.y() > middle && front.y() < upper(x) + 2.0) return Region::kUpperLip;
    if (front.y() <= middle && front.y() > lower(x) - 2.0) return Region::kLowerLip;
  }
  const double s = (x - 17.4) / (44.6 - 17.4);
  if (s > 0.0 && s < 1.0) {
    const double up = front.y() - lid_margin(s, +1).y();
    const double down = lid_margin(s, -1).y() - front.y();
    if (up > 0.0 && up < 8.0) return Region::kUpperLid;
    if (down > 0.0 && down < 6.0) return Region::kLowerLid;
  }
  return Region::kFace;
}

// Carries the muscle table's canonical face onto this head's frontal picture: landmarks to
// landmarks, their displacements blended by inverse distance, then the shape and its identity.
struct LandmarkPair {
  double from_x, from_y, to_x, to_y;
};
constexpr std::array<LandmarkPair, 11> kLandmarks{{
    {31.5, 0, 31.5, 0},
    {8, 16, 10.5, 17},
    {35, 16, 35, 23},
    {58, 20, 54, 19.5},
    {17, -44, 17, -42},
    {28, -77, 25.4, -70.4},
    {0, -76, 0, -69},
    {0, -118, 0, -99},
    {0, -128, 0, -109},
    {67, -13, 68, -14},
    {0, 76, 0, 75},
}};

Vec2 head_from_canonical(const HeadShape& shape, const Vec2& canonical) {
  Vec2 shift = Vec2::Zero();
  double total = 0.0;
  for (const LandmarkPair& pair : kLandmarks) {
    for (const double side : {1.0, -1.0}) {
      const Vec2 from(side * pair.from_x, pair.from_y);
      const Vec2 by(side * (pair.to_x - pair.from_x), pair.to_y - pair.from_y);
      const double w = 1.0 / (1e-6 + std::pow((canonical - from).norm(), 3.0));
      shift += w * by;
      total += w;
    }
  }
  const Vec2 front = canonical + shift / total;
  const double x = std::min(std::abs(front.x()), 66.0);
  DomainPoint point{shape.domain_from_front({x, front.y()})};
  Vec2 head = shape.position(point).head<2>();
  head.x() += std::abs(front.x()) - x;
  if (front.x() < 0.0) head.x() = -head.x();
  return head;
}

SurfaceMesh lifted(const HeadShape& shape, const DomainMesh& domain) {
  SurfaceMesh mesh;
  mesh.triangles = domain.triangles;
  mesh.positions_mm.reserve(domain.points.size());
  for (const DomainPoint& p : domain.points) mesh.positions_mm.push_back(shape.position(p));
  return mesh;
}

// All edges but those of mouth and eyes: the neck, and behind ears and forehead.
std::vector<char> find_cut(const Anatomy& anatomy) {
  std::vector<char> cut_off(anatomy.region.size(), 0);
  for (const auto& [edge, uses] : edge_uses(anatomy.surface.triangles)) {
    for (const int v : edge) cut_off[v] |= uses == 1 && anatomy.region[v] == Region::kFace;
  }
  return cut_off;
}

}  // namespace

void Identity::check() const {
  require_range("identity: face_width", face_width, 0.88, 1.14);
  require_range("identity: face_height", face_height, 0.90, 1.12);
  require_range("identity: jaw_width", jaw_width, 0.85, 1.18);
  require_range("identity: nose_length", nose_length, 0.85, 1.18);
  require_range("identity: nose_width", nose_width, 0.80, 1.30);
  require_range("identity: lip_fullness", lip_fullness, 0.70, 1.45);
  require_range("identity: brow_height_mm", brow_height_mm, -4.0, 5.0);
  require_range("identity: eye_distance", eye_distance, 0.93, 1.08);
  require_range("identity: chin_length", chin_length, 0.85, 1.20);
  require_range("identity: stubble", stubble, 0.0, 1.0);
  require_colour("identity: skin_tone", skin_tone);
  require_colour("identity: hair_tone", hair_tone);
}

void HeadOptions::check() const {
  require_range("head: num_surface_vertices", num_surface_vertices, 300, 4000);
  require_range("head: skin_levels", skin_levels, 0, 3);
  require_range("head: albedo_size_px", albedo_size_px, 64, 4096);
}

Anatomy make_generic_head(const Identity& identity, const HeadOptions& options) {
  identity.check();
  options.check();
  const HeadShape shape(identity);
  const DomainMesh domain = mesh_domain(shape, options.num_surface_vertices);

  Anatomy anatomy;
  anatomy.surface = lifted(shape, domain);
  for (const DomainPoint& point : domain.points) {
    const Vec2 front = shape.front_from_domain(point.at_mm);
    anatomy.tissue_depth_mm.push_back(tissue_depth(shape, point, front));
    anatomy.mandible_weight.push_back(mandible_weight(shape, point));
    anatomy.region.push_back(region_of(shape, point, front));
  }
  anatomy.cut_off = find_cut(anatomy);

  FineSkin fine = refine(shape, domain, options.skin_levels);
  anatomy.curves = lay_curves(shape, fine.domain);
  anatomy.skin.mesh = lifted(shape, fine.domain);
  for (const DomainPoint& p : fine.domain.points) {
    anatomy.skin.uv.push_back(uv_from_domain(p.at_mm));
  }
  anatomy.skin.embedding = std::move(fine.embedding);
  anatomy.skin.albedo = paint_skin(shape, identity, options.albedo_size_px);
  anatomy.skin.relief = carve_relief(shape, identity, options.albedo_size_px);
  anatomy.skin.furrow_sites = lay_furrows(shape, fine.domain, anatomy.skin.mesh);
  anatomy.rigid_parts = make_rigid_parts(shape, identity);
  anatomy.teeth = make_teeth(shape);
  anatomy.muscles = standard_muscles(
      anatomy.surface, [&shape](Vec2 canonical) { return head_from_canonical(shape, canonical); });
  return anatomy;
}

}  // namespace zygoma
