#include "face/head_relief.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "face/appearance.h"
#include "face/noise.h"

namespace zygoma {
namespace {

// A line along which skin folds, in the frontal picture, x >= 0.
struct FurrowLine {
  std::vector<Vec2> points;
  double spacing_mm;   // to the next fold
  double width_mm;     // half width of its bottom
  double strength;     // share of the amplitude that shows here
  double bulge = 0.0;  // height of a cushion on the left of the way, over the furrow's depth
};

// Forehead lines are not ruled: they dip in the middle and waver.
FurrowLine forehead_line(double y, double reach, double strength) {
  return {{{0.0, y - 1.4},
           {0.22 * reach, y - 0.6},
           {0.5 * reach, y + 1.0},
           {0.78 * reach, y + 0.8},
           {reach, y - 1.6}},
          8.0,
          1.05,
          strength};
}

const std::vector<FurrowLine>& furrow_lines() {
  static const std::vector<FurrowLine> lines{
      forehead_line(35.0, 45.0, 0.75),
      forehead_line(42.5, 51.0, 1.0),
      forehead_line(50.5, 53.0, 0.9),
      forehead_line(59.0, 46.0, 0.7),
      {{{4.6, 9.0}, {5.4, 17.0}, {7.0, 29.0}}, 9.0, 1.1, 0.9},        // between the brows
      {{{0.0, 5.5}, {4.0, 5.3}, {8.0, 6.5}}, 6.0, 0.9, 0.8},          // root of the nose
      {{{6.5, -5.0}, {9.5, -8.0}, {12.0, -12.5}}, 5.0, 0.8, 0.8},     // its sides
      {{{7.0, -10.5}, {10.5, -14.0}, {13.0, -19.0}}, 5.0, 0.8, 0.8},  //
      {{{49.0, 2.0}, {55.0, 5.5}, {62.0, 11.0}}, 8.0, 0.9, 1.15},     // crow's feet
      {{{50.0, -1.8}, {57.0, -1.6}, {65.0, -0.5}}, 8.0, 0.9, 0.8},    //
      {{{49.5, -5.5}, {55.5, -9.0}, {62.0, -14.0}}, 8.0, 0.9, 1.15},  //
      {{{19.0, -9.0}, {26.0, -13.2}, {34.0, -13.8}, {43.0, -10.5}},
       7.0,
       0.9,
       0.6},                                                             // below the eye
      {{{23.0, -18.0}, {33.0, -20.5}, {43.0, -17.5}}, 8.0, 1.2, 0.6},    //
      {furrow_line(), 14.0, 2.2, 1.15, 0.5},                             // nose to mouth
      {{{37.0, -57.0}, {41.0, -66.0}, {41.5, -78.0}}, 12.0, 2.4, 0.4},   // round the smile
      {{{29.5, -74.0}, {32.5, -82.0}, {33.5, -91.0}}, 10.0, 1.8, 0.45},  // mouth to chin
      {{{0.0, -87.5}, {8.0, -87.0}, {15.5, -84.0}}, 11.0, 2.0, 0.6},     // above the chin
  };
  return lines;
}

// Where a point lies by a line.
struct Beside {
  double distance_mm = 1e9;  // + on the left of the way
  double along = 0.0;        // [0, 1]
  Vec2 across{0.0, 1.0};
};

Beside beside(const FurrowLine& line, const Vec2& p) {
  Beside best;
  const auto pieces = static_cast<double>(line.points.size() - 1);
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const Vec2 along = line.points[i + 1] - line.points[i];
    const double t = std::clamp((p - line.points[i]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const Vec2 off = p - line.points[i] - t * along;
    if (off.norm() >= std::abs(best.distance_mm)) continue;
    const Vec2 across = Vec2(-along.y(), along.x()).normalized();
    best = {off.dot(across) < 0.0 ? -off.norm() : off.norm(),
            (static_cast<double>(i) + t) / pieces,
            across};
  }
  return best;
}

bool near(const FurrowLine& line, const Vec2& p, double reach) {
  return std::any_of(line.points.begin(), line.points.end(), [&](const Vec2& q) {
    return (p - q).cwiseAbs().maxCoeff() < reach + 14.0;
  });
}

// Lines end softly, but run on over the middle of the face.
double fade(const FurrowLine& line, double along) {
  const double start = line.points.front().x() == 0.0 ? 1.0 : smooth_step(0.0, 0.20, along);
  return start * smooth_step(1.0, 0.75, along);
}

double furrow_height(const Vec2& front) {
  double height = 0.0;
  for (const FurrowLine& line : furrow_lines()) {
    const double w = line.width_mm;
    if (!near(line, front, 5.0 * w)) continue;
    const Beside at = beside(line, front);
    const double d = at.distance_mm / w;
    if (std::abs(d) > 5.0) continue;
    // A narrow bottom between two rounded shoulders.
    const double profile = 0.42 * (bump((d - 2.1) / 1.3) + bump((d + 2.1) / 1.3)) +
                           line.bulge * bump((d - 2.6) / 1.9) - 1.1 * bump(d);
    height += line.strength * fade(line, at.along) * profile;
  }
  return std::max(-1.2, height);
}

double pore_height(const Vec2& domain, const Vec2& front, std::uint32_t seed) {
  // Pores: pits where two waves of noise meet; large on nose and cheek, none on lids and lips.
  const double x = domain.x();
  const double y = domain.y();
  const double fine = noise(x / 0.75, y / 0.75, seed + 41) + noise(x / 0.5, y / 0.5, seed + 42);
  const double mesh = noise(x / 2.2 + 0.3 * y, y / 2.2 - 0.3 * x, seed + 43);
  const double nose = bump(std::hypot(front.x() / 16.0, (front.y() + 36.0) / 16.0));
  const double cheek = bump(std::hypot((front.x() - 30.0) / 22.0, (front.y() + 30.0) / 22.0));
  const double eye = bump(std::hypot((front.x() - 31.0) / 22.0, (front.y() - 1.0) / 12.0));
  const double coarse = (0.55 + 0.5 * nose + 0.35 * cheek) * (1.0 - 0.85 * eye);
  return 0.016 * coarse * (fine + 0.8 * mesh);
}

// Lines across the lips.
double lip_height(const Vec2& domain, const Vec2& front, std::uint32_t seed) {
  static const FunctionCurve upper(upper_lip_border());
  static const FunctionCurve lower(lower_lip_border());
  const double inside = std::min(upper(front.x()) - front.y(), front.y() - lower(front.x()));
  const double red = smooth_step(0.0, 1.6, inside) * smooth_step(25.0, 20.0, front.x());
  const double x = domain.x();
  return 0.05 * red *
         (noise(x / 1.5, domain.y() / 9.0, seed + 51) +
          0.6 * noise(x / 0.8, domain.y() / 6.0, seed + 52));
}

}  // namespace

Relief carve_relief(const HeadShape& shape, const Identity& identity, int size_px) {
  Relief relief;
  relief.detail_mm.assign(std::size_t(size_px) * size_px, 0.0F);
  relief.furrow.assign(std::size_t(size_px) * size_px, 0.0F);
  const std::uint32_t seed = identity.texture_seed;
  over_texels(shape, size_px, [&](std::size_t texel, const Vec2& domain, const Vec2& front) {
    const bool on_face = std::abs(domain.x()) < 110.0 && domain.y() > -130.0 && domain.y() < 85.0;
    if (!on_face || shape.hair_mm(domain) > 0.5) return;
    double detail = pore_height(domain, front, seed);
    if (front.x() < 26.0 && front.y() < -58.0 && front.y() > -80.0) {
      const double lips = lip_height(domain, front, seed);
      detail = lips != 0.0 ? lips + 0.2 * detail : detail;
    }
    relief.detail_mm[texel] = static_cast<float>(detail);
    const bool in_front = std::abs(domain.x()) < 75.0;
    if (in_front) relief.furrow[texel] = static_cast<float>(furrow_height(front));
  });
  return relief;
}

std::vector<FurrowSite> lay_furrows(const HeadShape& shape,
                                    const DomainMesh& fine,
                                    const SurfaceMesh& lifted) {
  std::vector<Vec3> normals(lifted.positions_mm.size(), Vec3::Zero());
  for (const Triangle& t : lifted.triangles) {
    const Vec3& a = lifted.positions_mm[t[0]];
    const Vec3 normal = (lifted.positions_mm[t[1]] - a).cross(lifted.positions_mm[t[2]] - a);
    for (const int v : t) normals[v] += normal;
  }
  std::vector<FurrowSite> sites(fine.points.size());
  for (std::size_t v = 0; v < sites.size(); ++v) {
    const DomainPoint& point = fine.points[v];
    if (point.rim != Rim::kNone || std::abs(point.at_mm.x()) > 75.0) continue;
    const Vec2 front = shape.front_from_domain(point.at_mm);
    double most = 0.25;
    Vec2 across = Vec2::Zero();
    for (const FurrowLine& line : furrow_lines()) {
      if (!near(line, front, line.spacing_mm)) continue;
      const Beside at = beside(line, front);
      const double weight = bump(at.distance_mm / (0.75 * line.spacing_mm));
      if (weight <= most) continue;
      most = weight;
      across = at.across;
      sites[v].spacing_mm = static_cast<float>(line.spacing_mm);
    }
    if (sites[v].spacing_mm <= 0.0F) continue;
    if (point.at_mm.x() < 0.0) across.x() = -across.x();
    // The direction in the skin that is seen from the front as this one.
    const Vec3 n = normals[v].normalized();
    const double towards = -(n.x() * across.x() + n.y() * across.y()) / std::max(0.25, n.z());
    sites[v].across = Vec3(across.x(), across.y(), towards).normalized().cast<float>();
  }
  return sites;
}

}  // namespace zygoma
