#include "face/lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "face/lattice_build.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kThinnestMm = 0.3;  // no thinning below this
constexpr int kNormalRounds = 3;     // smoothing of the extrusion directions
constexpr int kThinningRounds = 60;

void check_surface(const Anatomy& anatomy) {
  const SurfaceMesh& surface = anatomy.surface;
  const std::size_t n = surface.positions_mm.size();
  require(n >= 3 && !surface.triangles.empty(), "surface: empty, expected a triangle mesh");
  require(anatomy.tissue_depth_mm.size() == n,
          "tissue_depth_mm: " + std::to_string(anatomy.tissue_depth_mm.size()) +
              " values, expected one per surface vertex (" + std::to_string(n) + ")");
  require(anatomy.mandible_weight.size() == n, "mandible_weight: expected one per surface vertex");
  require(anatomy.region.size() == n, "region: expected one per surface vertex");
  for (std::size_t v = 0; v < n; ++v) {
    const std::string name = "surface vertex " + std::to_string(v);
    require(surface.positions_mm[v].allFinite(), name + ": not finite");
    const double depth = anatomy.tissue_depth_mm[v];
    require(std::isfinite(depth) && depth > 0.0, name + ": tissue depth must be above 0 mm");
    const double weight = anatomy.mandible_weight[v];
    require(weight >= 0.0 && weight <= 1.0, name + ": mandible weight must be in [0, 1]");
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& tri = surface.triangles[t];
    const std::string name = "surface triangle " + std::to_string(t);
    for (const int v : tri) {
      require(v >= 0 && v < static_cast<int>(n), name + ": vertex index out of range");
    }
    const Vec3& a = surface.positions_mm[tri[0]];
    const double area =
        (surface.positions_mm[tri[1]] - a).cross(surface.positions_mm[tri[2]] - a).norm();
    require(area > 1e-9, name + ": no area");
  }
}

void collect_edges(const SurfaceMesh& surface, Lattice& lattice) {
  for (const auto& [edge, count] : edge_uses(surface.triangles)) {
    require(count <= 2,
            "surface edge " + std::to_string(edge[0]) + "-" + std::to_string(edge[1]) +
                ": used by more than two triangles");
    lattice.edges.push_back(edge);
  }
  lattice.neighbors = neighbors_by(lattice.edges, lattice.num_vertices);
  for (int v = 0; v < lattice.num_vertices; ++v) {
    require(!lattice.neighbors[v].empty(),
            "surface vertex " + std::to_string(v) + ": belongs to no triangle");
  }
}

// Smoothed normals, turned where needed until every triangle around a vertex sees its direction
// from outside (else a prism would be inside out whatever its depth).
std::vector<Vec3> extrusion_directions(const SurfaceMesh& surface, const Lattice& lattice) {
  std::vector<Vec3> direction = smooth_normals(surface, lattice.neighbors, kNormalRounds);
  std::vector<std::vector<Vec3>> faces(lattice.num_vertices);
  for (const Triangle& t : surface.triangles) {
    const Vec3 n = area_vector(surface, t).normalized();
    for (const int v : t) faces[v].push_back(n);
  }
  constexpr double kSmallestCosine = 0.35;
  for (int v = 0; v < lattice.num_vertices; ++v) {
    for (int round = 0; round < 30; ++round) {
      const auto worst =
          std::min_element(faces[v].begin(), faces[v].end(), [&](const Vec3& a, const Vec3& b) {
            return a.dot(direction[v]) < b.dot(direction[v]);
          });
      if (worst->dot(direction[v]) >= kSmallestCosine) break;
      direction[v] = (direction[v] + 0.3 * *worst).normalized();
    }
  }
  return direction;
}

// How well a prism of a triangle is filled: volume against the upper triangle's area times the
// height, and no corner of the lower triangle turned over.
double fill(const LatticeBuild& build, const Triangle& t, double upper_share, double lower_share) {
  PrismCorners x;
  for (int c = 0; c < 3; ++c) {
    x[c] = build.below(t[c], upper_share);
    x[c + 3] = build.below(t[c], lower_share);
  }
  const Vec3 upper = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]);
  const Vec3 lower = 0.5 * (x[4] - x[3]).cross(x[5] - x[3]);
  const double area = upper.norm();
  const double height_mm = (lower_share - upper_share) * build.mean(build.depth_mm, t);
  const double by_volume = signed_volume(x) / (area * height_mm);
  const double by_base = 2.0 * lower.dot(upper) / (area * area);
  return std::min(by_volume, by_base);
}

// Shares the wish of every vertex with its neighbours so that the depth changes gently.
void limit_depth_slope(LatticeBuild& build) {
  constexpr double kLargestSlope = 0.6;
  // To the fixed point, which does not depend on the order of the edges.
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : build.lattice.edges) {
      const double reach =
          kLargestSlope * (build.surface.positions_mm[a] - build.surface.positions_mm[b]).norm();
      double& da = build.depth_mm[a];
      double& db = build.depth_mm[b];
      changed = changed || da > db + reach || db > da + reach;
      da = std::min(da, db + reach);
      db = std::min(db, da + reach);
    }
  }
}

// Thins the tissue where a prism would be inside out or nearly so, round by round.
void fit_depth(LatticeBuild& build) {
  const LatticeOptions& options = build.options;
  for (int round = 0;; ++round) {
    limit_depth_slope(build);
    std::vector<double> factor(build.depth_mm.size(), 1.0);
    bool failing = false;
    for (const Triangle& t : build.surface.triangles) {
      if (build.mean(build.depth_mm, t) < Column::kThinMm) continue;  // will keep no volume
      for (std::size_t layer = 0; layer < options.layers.size(); ++layer) {
        if (fill(build, t, build.share_above(layer), options.layers[layer].bottom_share) >=
            options.smallest_fill) {
          continue;
        }
        for (const int v : t) {
          factor[v] = 0.88;
          failing = failing || build.depth_mm[v] > kThinnestMm;
        }
      }
    }
    if (!failing || round == kThinningRounds) return;
    for (std::size_t v = 0; v < factor.size(); ++v) {
      double& depth = build.depth_mm[v];
      depth = std::max(std::min(kThinnestMm, depth), factor[v] * depth);
    }
  }
}

// A sheet of thickness h resists with a stiffness ~ 1/h across and 1/h along: thin flaps (inside of
// the lips, lids) would be welded to what lies below. They are loose in life.
double softening(double depth_mm) {
  constexpr double kFullMm = 6.0;
  const double share = std::min(1.0, depth_mm / kFullMm);
  return std::max(0.04, share * share);
}

}  // namespace

std::vector<TissueLayer> tri_layer() {
  return {{"dermis", 0.22, 30.0, 4.0, 5.0, 30.0},
          {"fat", 0.67, 10.0, 4.0, 8.0, 10.0},
          {"muscle", 1.0, 4.0, 1.0, 18.0, 10.0}};
}

std::vector<TissueLayer> bi_layer() {
  // The skin of the bi-layer stands for dermis and fat together: their moduli by thickness.
  return {{"skin", 0.67, 17.0, 4.0, 7.0, 17.0}, {"muscle", 1.0, 4.0, 1.0, 18.0, 10.0}};
}

void LatticeOptions::check() const {
  require(layers.size() >= 2, "layers: expected at least two, such as skin and muscle");
  double above = 0.0;
  for (const TissueLayer& layer : layers) {
    require(layer.bottom_share > above && layer.bottom_share <= 1.0,
            layer.name + ": bottom_share is " + shortest_text(layer.bottom_share) +
                ", expected to grow from layer to layer, up to 1");
    require_range(layer.name + ": modulus_kpa", layer.modulus_kpa, 1e-3, 1e5);
    require_range(layer.name + ": stiff_ratio", layer.stiff_ratio, 1.0, 1e6);
    require_range(layer.name + ": bulk_ratio", layer.bulk_ratio, 0.0, 1e4);
    require_range(layer.name + ": alpha_mn_per_mm", layer.alpha_mn_per_mm, 1e-6, 1e6);
    above = layer.bottom_share;
  }
  require(above == 1.0, layers.back().name + ": the last layer must end on bone (1)");
  require_range("epidermis_modulus_kpa", epidermis_modulus_kpa, 1e-3, 1e5);
  require_range("epidermis_thickness_mm", epidermis_thickness_mm, 1e-3, 1.0);
  require_range("epidermis_stiff_ratio", epidermis_stiff_ratio, 1.0, 1e6);
  require_range("epidermis_alpha_mn_per_mm", epidermis_alpha_mn_per_mm, 1e-6, 1e6);
  for (const double factor : region_stiffness) require_range("region_stiffness", factor, 1e-3, 100);
  require_range("density_kg_per_mm3", density_kg_per_mm3, 1e-9, 1e-3);
  require_range("smallest_fill", smallest_fill, 0.05, 0.8);
}

void SpringCollector::add(
    int i, int j, double volume_mm3, const TissueLayer& tissue, double factor) {
  Sum& sum = sums_[{std::min(i, j), std::max(i, j)}];
  if (options_.stiffness == Stiffness::kConstant) {
    const double alpha = factor * tissue.alpha_mn_per_mm;
    if (alpha > sum.alpha) sum = {alpha, alpha * tissue.stiff_ratio};
    return;
  }
  const double length2 = (lattice_.rest_mm[i] - lattice_.rest_mm[j]).squaredNorm();
  const double alpha = factor * tissue.modulus_kpa * volume_mm3 / std::max(length2, 1e-6);
  sum.alpha += alpha;
  sum.beta += alpha * tissue.stiff_ratio;
}

void SpringCollector::finish() {
  for (const auto& [ends, sum] : sums_) {
    const auto [i, j] = ends;
    if (!lattice_.is_free(std::min(i, j))) continue;
    const Spring spring = make_spring(
        i, j, lattice_.rest_mm[i], lattice_.rest_mm[j], sum.alpha, sum.beta / sum.alpha);
    lattice_.springs.push_back(options_.law == SpringLaw::kLiteral ? literal_spring(spring)
                                                                   : spring);
  }
}

double LatticeBuild::stiffness_factor(const Triangle& t) const {
  return softening(mean(depth_mm, t)) * mean(region_stiffness, t);
}

Vec3 area_vector(const SurfaceMesh& surface, const Triangle& t) {
  const Vec3& a = surface.positions_mm[t[0]];
  return 0.5 * (surface.positions_mm[t[1]] - a).cross(surface.positions_mm[t[2]] - a);
}

void add_epidermis(const LatticeBuild& build, SpringCollector& springs) {
  const LatticeOptions& options = build.options;
  const TissueLayer epidermis{"epidermis",
                              0.0,
                              options.epidermis_modulus_kpa,
                              options.epidermis_stiff_ratio,
                              0.0,
                              options.epidermis_alpha_mn_per_mm};
  for (const Triangle& t : build.surface.triangles) {
    const double volume = area_vector(build.surface, t).norm() * options.epidermis_thickness_mm;
    for (int e = 0; e < 3; ++e) {
      springs.add(
          t[e], t[(e + 1) % 3], volume / 3.0, epidermis, build.mean(build.region_stiffness, t));
    }
  }
}

std::vector<double> vertex_areas(const SurfaceMesh& surface) {
  std::vector<double> areas(surface.positions_mm.size(), 0.0);
  for (const Triangle& t : surface.triangles) {
    const double third = area_vector(surface, t).norm() / 3.0;
    for (const int v : t) areas[v] += third;
  }
  return areas;
}

std::vector<Vec3> smooth_normals(const SurfaceMesh& surface,
                                 const std::vector<std::vector<int>>& neighbors,
                                 int rounds) {
  std::vector<Vec3> normal(surface.positions_mm.size(), Vec3::Zero());
  for (const Triangle& t : surface.triangles) {
    const Vec3 n = area_vector(surface, t).normalized();
    for (int c = 0; c < 3; ++c) {
      const Vec3 a = surface.positions_mm[t[(c + 1) % 3]] - surface.positions_mm[t[c]];
      const Vec3 b = surface.positions_mm[t[(c + 2) % 3]] - surface.positions_mm[t[c]];
      normal[t[c]] += std::atan2(a.cross(b).norm(), a.dot(b)) * n;
    }
  }
  for (Vec3& n : normal) n.normalize();
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vec3> mean = normal;
    for (std::size_t v = 0; v < normal.size(); ++v) {
      for (const int u : neighbors[v]) mean[v] += normal[u];
      mean[v].normalize();
    }
    normal = std::move(mean);
  }
  return normal;
}

Lattice make_lattice(const Anatomy& anatomy, const LatticeOptions& options) {
  check_surface(anatomy);
  options.check();
  LatticeBuild build{anatomy.surface, options, {}, anatomy.tissue_depth_mm, {}, {}};
  build.lattice.num_vertices = static_cast<int>(anatomy.surface.positions_mm.size());
  collect_edges(anatomy.surface, build.lattice);
  build.direction = extrusion_directions(anatomy.surface, build.lattice);
  fit_depth(build);
  for (const Region region : anatomy.region) {
    build.region_stiffness.push_back(options.region_stiffness[static_cast<std::size_t>(region)]);
  }
  if (options.topology == Topology::kPrisms) {
    build_prisms(build);
  } else {
    build_centroids(build);
  }
  return std::move(build.lattice);
}

}  // namespace zygoma
