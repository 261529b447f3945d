#include "face/muscle_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <string>

#include "face/muscle_ring.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Closest point of a triangle to p, and its distance.
double distance_to_triangle(const SurfaceMesh& surface, const Triangle& t, const Vec3& p) {
  const Vec3& a = surface.positions_mm[t[0]];
  const Vec3 ab = surface.positions_mm[t[1]] - a;
  const Vec3 ac = surface.positions_mm[t[2]] - a;
  const Vec3 n = ab.cross(ac);
  const double n2 = n.squaredNorm();
  const double v = (p - a).cross(ac).dot(n) / n2;
  const double w = ab.cross(p - a).dot(n) / n2;
  if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return std::abs((p - a).dot(n)) / std::sqrt(n2);
  double best = kInfinity;
  for (int e = 0; e < 3; ++e) {
    const Vec3& s = surface.positions_mm[t[e]];
    const Vec3 d = surface.positions_mm[t[(e + 1) % 3]] - s;
    const double u = std::clamp((p - s).dot(d) / d.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (p - s - u * d).norm());
  }
  return best;
}

// Distance at c of a wave that passes a and b at distances da and db: the triangle is laid flat
// with a at the origin and b on the x axis, the source is reconstructed below it.
double unfold(double da, double db, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const double base = ab.norm();
  const double cx = (c - a).dot(ab) / base;
  const double cy = ((c - a) - (cx / base) * ab).norm();
  const double along_edges = std::min(da + (c - a).norm(), db + (c - b).norm());
  const double sx = (da * da - db * db + base * base) / (2.0 * base);
  const double sy2 = da * da - sx * sx;
  if (sy2 < 0.0) return along_edges;
  const double sy = -std::sqrt(sy2);
  const double crossing = sx + (cx - sx) * (-sy) / (cy - sy);
  if (!(crossing >= 0.0 && crossing <= base)) return along_edges;
  return std::min(along_edges, std::hypot(cx - sx, cy - sy));
}

// The flap of a slit a muscle leaves alone, as a mask over the vertices.
std::vector<char> spared_vertices(const Anatomy& anatomy, const std::vector<double>& distance) {
  constexpr double kCornerMm = 8.0;  // closer alike than this: attached at the corner
  constexpr std::array<std::array<Region, 2>, 2> kSlits{
      {{Region::kUpperLip, Region::kLowerLip}, {Region::kUpperLid, Region::kLowerLid}}};
  std::vector<char> spared(distance.size(), 0);
  for (const double side : {1.0, -1.0}) {
    for (const auto& slit : kSlits) {
      std::array<double, 2> nearest{kInfinity, kInfinity};
      const auto in_flap = [&](std::size_t v, int flap) {
        // Lids come in pairs: each eye is a slit of its own. The mouth is one.
        const bool this_side = side * anatomy.surface.positions_mm[v].x() >= 0.0;
        return anatomy.region[v] == slit[flap] && (slit[0] == Region::kUpperLip || this_side);
      };
      for (std::size_t v = 0; v < distance.size(); ++v) {
        for (int flap = 0; flap < 2; ++flap) {
          if (in_flap(v, flap)) nearest[flap] = std::min(nearest[flap], distance[v]);
        }
      }
      // Infinity means beyond the muscle's reach anyway.
      int farther = -1;
      if (nearest[0] > nearest[1] + kCornerMm) farther = 0;
      if (nearest[1] > nearest[0] + kCornerMm) farther = 1;
      if (farther < 0) continue;
      for (std::size_t v = 0; v < distance.size(); ++v) {
        if (in_flap(v, farther)) spared[v] = 1;
      }
    }
  }
  return spared;
}

void check_muscle(const Muscle& muscle) {
  const std::string name = "muscle " + muscle.name + ": ";
  require(muscle.attachment_mm.allFinite() && muscle.emergence_mm.allFinite(),
          name + "end point not finite");
  require(std::isfinite(muscle.radius_mm) && muscle.radius_mm > 0.0,
          name + "radius must be above 0 mm");
  require(muscle.largest_shortening > 0.0 && muscle.largest_shortening <= 1.0,
          name + "largest shortening must be in (0, 1]");
  require((muscle.emergence_mm - muscle.attachment_mm).norm() > 1e-3,
          name + "attachment and emergence coincide");
  require(muscle.scalp_share >= 0.0 && muscle.scalp_share <= 1.0,
          name + "scalp share must be in [0, 1]");
  if (!muscle.ring) return;
  const Ring& ring = *muscle.ring;
  require(ring.forward.allFinite() && std::abs(ring.forward.norm() - 1.0) < 1e-6,
          name + "forward direction must have length 1");
  require(ring.aspect > 0.0 && ring.aspect <= 10.0, name + "aspect must be in (0, 10]");
  require(ring.hole >= 0.0 && ring.hole < ring.rim && ring.rim < 1.0,
          name + "hole and rim must be in order, in [0, 1)");
  require(std::abs(ring.along) <= 1.0 && std::abs(ring.across) <= 1.0,
          name + "shares along and across must be in [-1, 1]");
  require(std::isfinite(ring.forward_mm), name + "forward motion not finite");
}

// Normals of the head at large: the area around a vertex, averaged with a Gaussian in space, so
// that they do not depend on how finely the surface is meshed and both lips have the same. Skin
// that turns inwards (inside of the lips, rims of the lids) does not count, else neighbours would
// be pulled in opposite directions.
std::vector<Vec3> broad_normals(const SurfaceMesh& surface) {
  constexpr double kBroadMm = 10.0;
  constexpr double kReachMm = 3.0 * kBroadMm;
  constexpr double kOutwards = 0.4;  // cosine
  struct Patch {
    Vec3 centre_mm;
    Vec3 area;
  };
  std::vector<Patch> patches;
  for (const Triangle& t : surface.triangles) {
    const Vec3& a = surface.positions_mm[t[0]];
    const Vec3& b = surface.positions_mm[t[1]];
    const Vec3& c = surface.positions_mm[t[2]];
    patches.push_back({(a + b + c) / 3.0, (b - a).cross(c - a)});
  }
  std::vector<Vec3> broad(surface.positions_mm.size(), Vec3::Zero());
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t v = 0; v < broad.size(); ++v) {
      Vec3 sum = Vec3::Zero();
      for (const Patch& patch : patches) {
        const double d2 = (patch.centre_mm - surface.positions_mm[v]).squaredNorm();
        if (d2 > kReachMm * kReachMm) continue;
        if (pass == 1 && patch.area.dot(broad[v]) < kOutwards * patch.area.norm()) continue;
        sum += std::exp(-0.5 * d2 / (kBroadMm * kBroadMm)) * patch.area;
      }
      if (sum.squaredNorm() > 0.0) broad[v] = sum.normalized();
    }
  }
  return broad;
}

// A fibre pulls its skin end towards the bone. Where its other end is no bone but the scalp, that
// comes a little towards the skin end too.
VertexPull pull_of_fibre(const Muscle& muscle,
                         const Anatomy& anatomy,
                         const std::vector<Vec3>& normal,
                         const std::vector<double>& distinct) {
  const Vec3 m = muscle.emergence_mm - muscle.attachment_mm;
  VertexPull pull(normal.size());
  const auto add = [&](const Vec3& end_mm, double share) {
    const std::vector<double> distance = distance_along(anatomy.surface, end_mm, muscle.radius_mm);
    const std::vector<char> spared = spared_vertices(anatomy, distance);
    for (std::size_t v = 0; v < distance.size(); ++v) {
      if (!(distance[v] < muscle.radius_mm)) continue;
      const double reached = spared[v] ? 1.0 - distinct[v] : 1.0;
      const double b = std::cos(0.5 * std::numbers::pi * distance[v] / muscle.radius_mm) * reached;
      pull.blend[v] = std::max(pull.blend[v], std::abs(share) * b);
      pull.displacement_mm[v] +=
          share * muscle.largest_shortening * b * tangent_with_length(m, normal[v]);
    }
  };
  add(muscle.attachment_mm, 1.0);
  if (muscle.scalp_share > 0.0) add(muscle.emergence_mm, -muscle.scalp_share);
  return pull;
}

// Dijkstra over the vertices, with the unfolded wave as the length of a step.
std::vector<double> spread(const SurfaceMesh& surface,
                           const std::vector<double>& seed,
                           double reach_mm) {
  const std::size_t n = surface.positions_mm.size();
  std::vector<std::vector<Triangle>> around(n);
  for (const Triangle& t : surface.triangles) {
    for (int c = 0; c < 3; ++c) around[t[c]].push_back({t[c], t[(c + 1) % 3], t[(c + 2) % 3]});
  }
  std::vector<double> distance(n, kInfinity);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  const auto improve = [&](int v, double d) {
    if (!(d < distance[v] - 1e-12) || d > reach_mm) return;
    distance[v] = d;
    front.push({d, v});
  };
  for (std::size_t v = 0; v < n; ++v) improve(static_cast<int>(v), seed[v]);
  while (!front.empty()) {
    const auto [d, v] = front.top();
    front.pop();
    if (d > distance[v]) continue;
    for (const Triangle& t : around[v]) {
      for (const auto& [known, target] : {std::pair{t[1], t[2]}, std::pair{t[2], t[1]}}) {
        const Vec3& xv = surface.positions_mm[v];
        const Vec3& xt = surface.positions_mm[target];
        improve(target, d + (xt - xv).norm());
        if (distance[known] == kInfinity) continue;
        improve(target, unfold(d, distance[known], xv, surface.positions_mm[known], xt));
      }
    }
  }
  return distance;
}

}  // namespace

std::vector<double> distance_along(const SurfaceMesh& surface,
                                   const Vec3& from_mm,
                                   double reach_mm) {
  double nearest = kInfinity;
  for (const Triangle& t : surface.triangles) {
    nearest = std::min(nearest, distance_to_triangle(surface, t, from_mm));
  }
  std::vector<double> seed(surface.positions_mm.size(), kInfinity);
  for (const Triangle& t : surface.triangles) {
    if (distance_to_triangle(surface, t, from_mm) > nearest + 1e-9) continue;
    for (const int v : t) seed[v] = (surface.positions_mm[v] - from_mm).norm();
  }
  return spread(surface, seed, reach_mm);
}

std::vector<double> distance_along(const SurfaceMesh& surface,
                                   const std::vector<char>& from,
                                   double reach_mm) {
  std::vector<double> seed(from.size(), kInfinity);
  for (std::size_t v = 0; v < from.size(); ++v) {
    if (from[v]) seed[v] = 0.0;
  }
  return spread(surface, seed, reach_mm);
}

double fold_measure(const Muscle& muscle) {
  if (!muscle.ring) {
    const double length = (muscle.emergence_mm - muscle.attachment_mm).norm();
    return muscle.largest_shortening * length * std::numbers::pi / (2.0 * muscle.radius_mm);
  }
  // On an axis p goes to p (1 - s b), whose slope is 1 - s (b + r db/dr).
  constexpr int kSamples = 64;
  double most = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    const double r0 = static_cast<double>(k) / kSamples;
    const double r1 = static_cast<double>(k + 1) / kSamples;
    const double slope =
        kSamples * (r1 * ring_blend(*muscle.ring, r1) - r0 * ring_blend(*muscle.ring, r0));
    most = std::max({most, muscle.ring->along * slope, muscle.ring->across * slope});
  }
  return muscle.largest_shortening * most;
}

int num_folded(const Anatomy& anatomy,
               const MuscleField& field,
               const std::vector<double>& contraction) {
  const SurfaceMesh& surface = anatomy.surface;
  const auto is_lid = [&](int v) {
    return anatomy.region[v] == Region::kUpperLid || anatomy.region[v] == Region::kLowerLid;
  };
  std::vector<Vec3> target = surface.positions_mm;
  for (std::size_t m = 0; m < contraction.size(); ++m) {
    for (const MusclePull& pull : field.pulls[m]) {
      // Columns of a lattice of prisms are the vertices.
      if (pull.column < static_cast<int>(target.size())) {
        target[pull.column] += contraction[m] * pull.displacement_mm;
      }
    }
  }
  const auto area = [](const std::vector<Vec3>& x, const Triangle& t) -> Vec3 {
    return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
  };
  int folded = 0;
  for (const Triangle& t : surface.triangles) {
    if (std::all_of(t.begin(), t.end(), is_lid)) continue;
    folded += area(target, t).dot(area(surface.positions_mm, t)) <= 0.0;
  }
  return folded;
}

MuscleField make_muscle_field(const Anatomy& anatomy, const Lattice& lattice) {
  const std::vector<Vec3> normal = broad_normals(anatomy.surface);
  const std::vector<double> distinct = distinct_flaps(anatomy, lattice.neighbors);
  MuscleField field;
  field.hold.assign(lattice.columns.size(), 0.0);
  for (const Muscle& muscle : anatomy.muscles) {
    check_muscle(muscle);
    const VertexPull pull = muscle.ring ? pull_of_ring(muscle, anatomy, normal, distinct)
                                        : pull_of_fibre(muscle, anatomy, normal, distinct);
    std::vector<MusclePull> pulls;
    for (std::size_t c = 0; c < lattice.columns.size(); ++c) {
      const Column& column = lattice.columns[c];
      const double b = lattice.below(pull.blend, column);
      if (!column.on_bone || b <= 0.0) continue;
      pulls.push_back({static_cast<int>(c), b, lattice.below(pull.displacement_mm, column)});
      field.hold[c] = std::max(field.hold[c], b);
    }
    require(!pulls.empty(), "muscle " + muscle.name + ": reaches no vertex of the surface");
    field.pulls.push_back(std::move(pulls));
  }
  return field;
}

}  // namespace zygoma
