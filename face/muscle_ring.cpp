#include "face/muscle_ring.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "face/muscle_field.h"

namespace zygoma {
namespace {

// +1 upper, -1 lower, 0 neither.
int flap_of(Region region) {
  if (region == Region::kUpperLip || region == Region::kUpperLid) return 1;
  return region == Region::kFace ? 0 : -1;
}

bool is_lid(Region region) { return region == Region::kUpperLid || region == Region::kLowerLid; }

// The share of a halved ring at a place, `up_mm` above its axis.
double half_share(const Ring& ring, double x_mm, double up_mm, Region region, double distinct) {
  constexpr double kSeam_mm = 8.0;
  double share = 1.0;
  if (ring.side != 0) share *= smooth_step(-kSeam_mm, kSeam_mm, ring.side * x_mm);
  if (ring.flap != 0) {
    const double by_height = smooth_step(-kSeam_mm, kSeam_mm, ring.flap * up_mm);
    const double by_flap = flap_of(region) == ring.flap ? 1.0 : 0.0;
    const double certain = flap_of(region) == 0 ? 0.0 : distinct;
    share *= by_height + certain * (by_flap - by_height);
  }
  return share;
}

// `to` at the distance from the pivot that `from` has.
Vec3 on_ball(const Vec3& from, const Vec3& to, const Vec3& pivot) {
  return pivot + (to - pivot) * ((from - pivot).norm() / (to - pivot).norm());
}

// A ring's axes, and places relative to its centre.
struct RingFrame {
  Vec3 u;
  Vec3 v;

  explicit RingFrame(const Muscle& muscle) {
    const Vec3& forward = muscle.ring->forward;
    const Vec3 end = muscle.emergence_mm - muscle.attachment_mm;
    u = (end - end.dot(forward) * forward).normalized();
    v = forward.cross(u);
    if (v.y() < 0.0) v = -v;
  }
};

// Height over the ring's axis of the margin of a lid, along the slit. The margin is the row of
// vertices next to the border of the hole.
class LidMargin {
 public:
  LidMargin(const Muscle& muscle, const RingFrame& frame, const Anatomy& anatomy) {
    const SurfaceMesh& surface = anatomy.surface;
    const auto uses = edge_uses(surface.triangles);
    std::vector<char> border(surface.positions_mm.size(), 0);
    for (const auto& [edge, count] : uses) {
      if (count == 1) border[edge[0]] = border[edge[1]] = 1;
    }
    const auto add = [&](int v) {
      const Vec3 p = surface.positions_mm[v] - muscle.attachment_mm;
      if (p.norm() > muscle.radius_mm) return;
      line_[flap_of(anatomy.region[v]) > 0][p.dot(frame.u)] = p.dot(frame.v);
    };
    for (const auto& [edge, count] : uses) {
      const auto& [a, b] = edge;
      if (!is_lid(anatomy.region[a]) || !is_lid(anatomy.region[b])) continue;
      if (border[a] && !border[b]) add(b);
      if (border[b] && !border[a]) add(a);
    }
  }

  bool found() const { return line_[0].size() > 2 && line_[1].size() > 2; }

  double height(bool upper, double along) const {
    const std::map<double, double>& line = line_[upper];
    const auto after = line.lower_bound(along);
    if (after == line.begin() || after == line.end()) return 0.0;  // beyond the corners
    const auto before = std::prev(after);
    const double t = (along - before->first) / (after->first - before->first);
    return before->second + t * (after->second - before->second);
  }

 private:
  std::map<double, double> line_[2];  // lower, upper: height by place
};

// How far a point of a lid goes when its margin travels by `margin`: as far, but at the corners,
// where the margin's back is nearer to the axis, not much beyond the axis.
double lid_travel(double margin, double height) {
  constexpr double kBeyond_mm = 1.2;
  const double side = margin > 0.0 ? 1.0 : -1.0;
  return side * std::clamp(side * height + kBeyond_mm, 0.0, side * margin);
}

}  // namespace

Vec3 tangent_with_length(const Vec3& m, const Vec3& normal) {
  const Vec3 flat = m - m.dot(normal) * normal;
  return flat * (m.norm() / std::max(flat.norm(), 0.5 * m.norm()));
}

double ring_blend(const Ring& ring, double r) {
  const bool outside = r > ring.rim;
  if (!outside && ring.hole == 0.0) return 1.0;
  const double off =
      outside ? (r - ring.rim) / (1.0 - ring.rim) : (ring.rim - r) / (ring.rim - ring.hole);
  return 0.5 + 0.5 * std::cos(std::numbers::pi * std::min(off, 1.0));
}

std::vector<double> distinct_flaps(const Anatomy& anatomy,
                                   const std::vector<std::vector<int>>& neighbors) {
  constexpr double kFrom_mm = 2.0;
  constexpr double kTo_mm = 14.0;
  std::vector<char> corner(anatomy.region.size(), 0);
  for (std::size_t v = 0; v < corner.size(); ++v) {
    bool upper = flap_of(anatomy.region[v]) > 0;
    bool lower = flap_of(anatomy.region[v]) < 0;
    for (const int u : neighbors[v]) {
      upper = upper || flap_of(anatomy.region[u]) > 0;
      lower = lower || flap_of(anatomy.region[u]) < 0;
    }
    corner[v] = upper && lower;
  }
  std::vector<double> distinct = distance_along(anatomy.surface, corner, kTo_mm);
  for (double& d : distinct) d = smooth_step(kFrom_mm, kTo_mm, std::min(d, kTo_mm));
  return distinct;
}

VertexPull pull_of_ring(const Muscle& muscle,
                        const Anatomy& anatomy,
                        const std::vector<Vec3>& normal,
                        const std::vector<double>& distinct) {
  constexpr double kDetour = 1.6;  // along the skin, against the way through the air
  const Ring& ring = *muscle.ring;
  const RingFrame frame(muscle);
  std::optional<LidMargin> margin;
  if (ring.pivot_mm && ring.along == 0.0) margin.emplace(muscle, frame, anatomy);
  if (margin && !margin->found()) margin.reset();
  const double reach = muscle.radius_mm * std::max(1.0, ring.aspect);
  const std::vector<double> distance =
      distance_along(anatomy.surface, muscle.attachment_mm, kDetour * reach);
  VertexPull pull(distance.size());
  for (std::size_t k = 0; k < distance.size(); ++k) {
    if (!std::isfinite(distance[k])) continue;
    const Vec3& x = anatomy.surface.positions_mm[k];
    const Vec3 p = x - muscle.attachment_mm;
    const double pu = p.dot(frame.u);
    const double pv = p.dot(frame.v);
    const double r = std::hypot(pu, pv / ring.aspect) / muscle.radius_mm;
    const Region region = anatomy.region[k];
    const double b = ring_blend(ring, r) * half_share(ring, x.x(), pv, region, distinct[k]);
    if (b <= 0.0) continue;
    const bool upper = flap_of(region) != 0 ? flap_of(region) > 0 : pv > 0.0;
    const double off = margin ? lid_travel(margin->height(upper, pu), pv) : pv;
    Vec3 d =
        -muscle.largest_shortening * b * (ring.along * pu * frame.u + ring.across * off * frame.v);
    d = ring.pivot_mm ? on_ball(x, x + d, *ring.pivot_mm) - x : tangent_with_length(d, normal[k]);
    pull.blend[k] = b;
    pull.displacement_mm[k] = d + b * ring.forward_mm * ring.forward;
  }
  return pull;
}

}  // namespace zygoma
