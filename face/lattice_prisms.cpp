#include <string>

#include "face/lattice_build.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

void add_nodes(LatticeBuild& build) {
  Lattice& lattice = build.lattice;
  const int n = lattice.num_vertices;
  const int num_layers = static_cast<int>(build.options.layers.size());
  lattice.num_free_nodes = num_layers * n;
  lattice.columns.resize(n);
  for (int layer = 0; layer <= num_layers; ++layer) {
    for (int v = 0; v < n; ++v) {
      lattice.columns[v].nodes.push_back(static_cast<int>(lattice.rest_mm.size()));
      lattice.rest_mm.push_back(layer == 0 ? build.surface.positions_mm[v]
                                           : build.below(v, build.share_above(layer)));
      lattice.column_of.push_back(v);
    }
  }
  const std::vector<double> areas = vertex_areas(build.surface);
  for (int v = 0; v < n; ++v) {
    lattice.columns[v].vertex = {v, v, v};
    lattice.columns[v].depth_mm = build.depth_mm[v];
    lattice.columns[v].area_mm2 = areas[v];
  }
}

void add_element(LatticeBuild& build,
                 std::size_t layer,
                 std::size_t triangle,
                 SpringCollector& springs) {
  Lattice& lattice = build.lattice;
  const TissueLayer& tissue = build.options.layers[layer];
  const Triangle& t = build.surface.triangles[triangle];
  const int upper = static_cast<int>(layer) * lattice.num_vertices;
  const int lower = upper + lattice.num_vertices;
  Prism prism;
  prism.node = {upper + t[0], upper + t[1], upper + t[2], lower + t[0], lower + t[1], lower + t[2]};
  const double depth = build.mean(build.depth_mm, t);
  const double factor = build.stiffness_factor(t);
  const bool thin = depth < Column::kThinMm;
  if (thin) {
    const double share = tissue.bottom_share - build.share_above(layer);
    prism.rest_mm3 = area_vector(build.surface, t).norm() * share * depth;
  } else {
    prism.rest_mm3 = signed_volume(prism, lattice.rest_mm);
    prism.bulk_kpa = factor * tissue.bulk_ratio * tissue.modulus_kpa;
  }
  require(prism.rest_mm3 > 0.0,
          "surface triangle " + std::to_string(triangle) + ": the tissue below it (" + tissue.name +
              ") has no positive volume; is the mesh folded or facing inwards?");
  for (const int node : prism.node) {
    lattice.mass_kg[node] += build.options.density_kg_per_mm3 * prism.rest_mm3 / 6.0;
  }
  add_prism_springs(prism, tissue, factor, springs);
  if (!thin && tissue.bulk_ratio > 0.0) lattice.prisms.push_back(prism);
}

}  // namespace

void add_prism_springs(const Prism& prism,
                       const TissueLayer& tissue,
                       double factor,
                       SpringCollector& springs) {
  constexpr double kSpringsPerPrism = 15.0;
  const auto add = [&](int a, int b) {
    springs.add(prism.node[a], prism.node[b], prism.rest_mm3 / kSpringsPerPrism, tissue, factor);
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

void build_prisms(LatticeBuild& build) {
  add_nodes(build);
  Lattice& lattice = build.lattice;
  lattice.mass_kg.assign(lattice.rest_mm.size(), 0.0);
  SpringCollector springs(lattice, build.options);
  for (std::size_t layer = 0; layer < build.options.layers.size(); ++layer) {
    for (std::size_t t = 0; t < build.surface.triangles.size(); ++t) {
      add_element(build, layer, t, springs);
    }
  }
  add_epidermis(build, springs);
  springs.finish();
}

}  // namespace zygoma
