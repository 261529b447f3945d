#include "face/lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "face/prism.h"
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
  std::map<std::array<int, 2>, int> uses;
  for (const Triangle& t : surface.triangles) {
    for (int e = 0; e < 3; ++e) {
      const int a = t[e];
      const int b = t[(e + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  }
  lattice.neighbors.assign(lattice.num_columns, {});
  for (const auto& [edge, count] : uses) {
    require(count <= 2,
            "surface edge " + std::to_string(edge[0]) + "-" + std::to_string(edge[1]) +
                ": used by more than two triangles");
    lattice.edges.push_back(edge);
    lattice.neighbors[edge[0]].push_back(edge[1]);
    lattice.neighbors[edge[1]].push_back(edge[0]);
  }
  for (int v = 0; v < lattice.num_columns; ++v) {
    require(!lattice.neighbors[v].empty(),
            "surface vertex " + std::to_string(v) + ": belongs to no triangle");
    std::sort(lattice.neighbors[v].begin(), lattice.neighbors[v].end());
  }
}

Vec3 area_vector(const SurfaceMesh& surface, const Triangle& t) {
  const Vec3& a = surface.positions_mm[t[0]];
  return 0.5 * (surface.positions_mm[t[1]] - a).cross(surface.positions_mm[t[2]] - a);
}

// Smoothed normals, turned where needed until every triangle around a vertex sees its direction
// from outside (else a prism would be inside out whatever its depth).
std::vector<Vec3> extrusion_directions(const SurfaceMesh& surface, const Lattice& lattice) {
  std::vector<Vec3> direction = smooth_normals(surface, lattice.neighbors, kNormalRounds);
  std::vector<std::vector<Vec3>> faces(lattice.num_columns);
  for (const Triangle& t : surface.triangles) {
    const Vec3 n = area_vector(surface, t).normalized();
    for (const int v : t) faces[v].push_back(n);
  }
  constexpr double kSmallestCosine = 0.35;
  for (int v = 0; v < lattice.num_columns; ++v) {
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

PrismCorners prism_at_rest(const Lattice& lattice, const Triangle& t, int layer) {
  PrismCorners x;
  for (int c = 0; c < 3; ++c) {
    x[c] = lattice.rest_mm[layer * lattice.num_columns + t[c]];
    x[c + 3] = lattice.rest_mm[(layer + 1) * lattice.num_columns + t[c]];
  }
  return x;
}

// How well a prism is filled: volume against the upper triangle's area times the height, and no
// corner of the lower triangle turned over.
double fill(const PrismCorners& x, double height_mm) {
  PrismCorners unused;
  const Vec3 upper = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]);
  const Vec3 lower = 0.5 * (x[4] - x[3]).cross(x[5] - x[3]);
  const double area = upper.norm();
  const double by_volume = prism_volume(x, unused) / (area * height_mm);
  const double by_base = 2.0 * lower.dot(upper) / (area * area);
  return std::min(by_volume, by_base);
}

void extrude(const SurfaceMesh& surface,
             const std::vector<Vec3>& direction,
             const LatticeOptions& options,
             Lattice& lattice) {
  for (int v = 0; v < lattice.num_columns; ++v) {
    lattice.rest_mm[v] = surface.positions_mm[v];
    for (int layer = 1; layer < lattice.num_node_layers; ++layer) {
      const double share = options.layers[layer - 1].bottom_share;
      lattice.rest_mm[layer * lattice.num_columns + v] =
          surface.positions_mm[v] - (share * lattice.depth_mm[v]) * direction[v];
    }
  }
}

// Shares the wish of every column with its neighbours so that the depth changes gently.
void limit_depth_slope(const SurfaceMesh& surface, Lattice& lattice) {
  constexpr double kLargestSlope = 0.6;
  // To the fixed point, which does not depend on the order of the edges.
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : lattice.edges) {
      const double reach =
          kLargestSlope * (surface.positions_mm[a] - surface.positions_mm[b]).norm();
      double& da = lattice.depth_mm[a];
      double& db = lattice.depth_mm[b];
      changed = changed || da > db + reach || db > da + reach;
      da = std::min(da, db + reach);
      db = std::min(db, da + reach);
    }
  }
}

// Thins the tissue where a prism would be inside out or nearly so, round by round.
void fit_depth(const SurfaceMesh& surface, const LatticeOptions& options, Lattice& lattice) {
  const std::vector<Vec3> direction = extrusion_directions(surface, lattice);
  for (int round = 0;; ++round) {
    limit_depth_slope(surface, lattice);
    extrude(surface, direction, options, lattice);
    std::vector<double> factor(lattice.num_columns, 1.0);
    int failing = -1;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Triangle& tri = surface.triangles[t];
      const double mean_depth = lattice.mean_depth_mm(tri);
      if (mean_depth < Lattice::kThinMm) continue;  // will have no volume to keep
      double upper_share = 0.0;
      for (int layer = 0; layer + 1 < lattice.num_node_layers; ++layer) {
        const double share = options.layers[layer].bottom_share - upper_share;
        upper_share = options.layers[layer].bottom_share;
        if (fill(prism_at_rest(lattice, tri, layer), share * mean_depth) >= options.smallest_fill) {
          continue;
        }
        for (const int v : tri) {
          factor[v] = 0.88;
          if (lattice.depth_mm[v] > kThinnestMm) failing = static_cast<int>(t);
        }
      }
    }
    if (failing < 0 || round == kThinningRounds) return;
    for (int v = 0; v < lattice.num_columns; ++v) {
      lattice.depth_mm[v] =
          std::max(std::min(kThinnestMm, lattice.depth_mm[v]), factor[v] * lattice.depth_mm[v]);
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

void add_prisms(const SurfaceMesh& surface, const LatticeOptions& options, Lattice& lattice) {
  for (int layer = 0; layer + 1 < lattice.num_node_layers; ++layer) {
    const TissueLayer& tissue = options.layers[layer];
    const int upper = layer * lattice.num_columns;
    const int lower = upper + lattice.num_columns;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Triangle& tri = surface.triangles[t];
      Prism prism;
      prism.node = {upper + tri[0],
                    upper + tri[1],
                    upper + tri[2],
                    lower + tri[0],
                    lower + tri[1],
                    lower + tri[2]};
      const double depth = lattice.mean_depth_mm(tri);
      if (depth < Lattice::kThinMm) {
        // Stands for its share of tissue in the springs only; erased when they are made.
        const double share =
            tissue.bottom_share - (layer > 0 ? options.layers[layer - 1].bottom_share : 0.0);
        prism.rest_mm3 = area_vector(surface, tri).norm() * share * depth;
      } else {
        PrismCorners unused;
        prism.rest_mm3 = prism_volume(prism_at_rest(lattice, tri, layer), unused);
        prism.bulk_kpa = softening(depth) * tissue.bulk_ratio * tissue.modulus_kpa;
      }
      require(prism.rest_mm3 > 0.0,
              "surface triangle " + std::to_string(t) + ": the tissue below it (" + tissue.name +
                  ") has no positive volume; is the mesh folded or facing inwards?");
      lattice.prisms.push_back(prism);
    }
  }
}

// Springs between two nodes, with the stiffness they collect from the elements around them.
class SpringCollector {
 public:
  explicit SpringCollector(Lattice& lattice) : lattice_(lattice) {}

  // Adds the share of volume_mm3 of tissue to the spring between nodes i and j.
  void add(int i, int j, double volume_mm3, double modulus_kpa, double stiff_ratio) {
    const double length2 = (lattice_.rest_mm[i] - lattice_.rest_mm[j]).squaredNorm();
    const double alpha = modulus_kpa * volume_mm3 / std::max(length2, 1e-6);
    Sum& sum = sums_[{std::min(i, j), std::max(i, j)}];
    sum.alpha += alpha;
    sum.beta += alpha * stiff_ratio;
  }

  void finish() {
    for (const auto& [ends, sum] : sums_) {
      const auto [i, j] = ends;
      lattice_.springs.push_back(make_spring(
          i, j, lattice_.rest_mm[i], lattice_.rest_mm[j], sum.alpha, sum.beta / sum.alpha));
    }
  }

 private:
  struct Sum {
    double alpha = 0.0;
    double beta = 0.0;
  };
  Lattice& lattice_;
  std::map<std::array<int, 2>, Sum> sums_;
};

void add_springs(const SurfaceMesh& surface, const LatticeOptions& options, Lattice& lattice) {
  constexpr double kSpringsPerPrism = 15.0;  // 6 edges, 3 verticals, 6 struts
  SpringCollector collector(lattice);
  const std::size_t num_triangles = surface.triangles.size();
  for (std::size_t p = 0; p < lattice.prisms.size(); ++p) {
    const Prism& prism = lattice.prisms[p];
    const TissueLayer& tissue = options.layers[p / num_triangles];
    const double volume = prism.rest_mm3 / kSpringsPerPrism;
    const Triangle& tri = surface.triangles[p % num_triangles];
    const double modulus = softening(lattice.mean_depth_mm(tri)) * tissue.modulus_kpa;
    const auto add = [&](int a, int b) {
      collector.add(prism.node[a], prism.node[b], volume, modulus, tissue.stiff_ratio);
    };
    for (int c = 0; c < 3; ++c) {
      const int next = (c + 1) % 3;
      add(c, next);
      add(c + 3, next + 3);
      add(c, c + 3);
      add(c, next + 3);
      add(next, c + 3);
    }
  }
  // The epidermis is a membrane: too thin for elements of its own.
  for (const Triangle& t : surface.triangles) {
    const double volume = area_vector(surface, t).norm() * options.epidermis_thickness_mm / 3.0;
    for (int e = 0; e < 3; ++e) {
      collector.add(t[e],
                    t[(e + 1) % 3],
                    volume,
                    options.epidermis_modulus_kpa,
                    options.epidermis_stiff_ratio);
    }
  }
  collector.finish();
  // Between two bone nodes nothing is free to move.
  std::erase_if(lattice.springs, [&](const Spring& spring) {
    return std::min(spring.i, spring.j) >= lattice.num_free_nodes();
  });
}

void check_layers(const LatticeOptions& options) {
  require(!options.layers.empty(), "layers: expected at least one tissue layer");
  double above = 0.0;
  for (const TissueLayer& layer : options.layers) {
    require(layer.bottom_share > above && layer.bottom_share <= 1.0,
            layer.name + ": bottom_share must grow from layer to layer, up to 1");
    require(layer.modulus_kpa > 0.0 && layer.stiff_ratio >= 1.0 && layer.bulk_ratio >= 0.0,
            layer.name + ": modulus must be positive, stiff_ratio >= 1, bulk_ratio >= 0");
    above = layer.bottom_share;
  }
  require(above == 1.0, options.layers.back().name + ": the last layer must end on bone (1)");
}

}  // namespace

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
  check_layers(options);
  Lattice lattice;
  lattice.num_columns = static_cast<int>(anatomy.surface.positions_mm.size());
  lattice.num_node_layers = static_cast<int>(options.layers.size()) + 1;
  lattice.rest_mm.resize(lattice.num_node_layers * lattice.num_columns);
  lattice.depth_mm = anatomy.tissue_depth_mm;
  collect_edges(anatomy.surface, lattice);
  lattice.area_mm2.assign(lattice.num_columns, 0.0);
  for (const Triangle& t : anatomy.surface.triangles) {
    const double third = area_vector(anatomy.surface, t).norm() / 3.0;
    for (const int v : t) lattice.area_mm2[v] += third;
  }
  fit_depth(anatomy.surface, options, lattice);
  add_prisms(anatomy.surface, options, lattice);
  add_springs(anatomy.surface, options, lattice);
  std::erase_if(lattice.prisms, [](const Prism& prism) { return prism.bulk_kpa == 0.0; });
  return lattice;
}

}  // namespace zygoma
