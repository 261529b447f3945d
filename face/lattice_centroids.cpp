#include <algorithm>
#include <map>

#include "face/lattice_build.h"

namespace zygoma {
namespace {

void add_nodes(LatticeBuild& build) {
  Lattice& lattice = build.lattice;
  const SurfaceMesh& surface = build.surface;
  const int n = lattice.num_vertices;
  const int num_triangles = static_cast<int>(surface.triangles.size());
  const int num_layers = static_cast<int>(build.options.layers.size());
  lattice.num_free_nodes = n + (num_layers - 1) * num_triangles;
  lattice.rest_mm = surface.positions_mm;
  for (int v = 0; v < n; ++v) {
    Column column;
    column.vertex = {v, v, v};
    column.nodes = {v};
    column.on_bone = false;
    column.depth_mm = build.depth_mm[v];
    lattice.columns.push_back(column);
    lattice.column_of.push_back(v);
  }
  for (const Triangle& t : surface.triangles) {
    Column column;
    column.vertex = t;
    column.weight.setConstant(1.0 / 3.0);
    column.depth_mm = build.mean(build.depth_mm, t);
    column.area_mm2 = area_vector(surface, t).norm();
    lattice.columns.push_back(column);
  }
  for (int layer = 1; layer <= num_layers; ++layer) {
    const double share = build.share_above(layer);
    for (int t = 0; t < num_triangles; ++t) {
      Column& column = lattice.columns[n + t];
      column.nodes.push_back(static_cast<int>(lattice.rest_mm.size()));
      lattice.column_of.push_back(n + t);
      const Vec3 inward = -area_vector(surface, surface.triangles[t]).normalized();
      lattice.rest_mm.push_back(lattice.below(surface.positions_mm, column) +
                                share * column.depth_mm * inward);
    }
  }
}

// The tetrahedral unit of a triangle and the chain below it.
void add_unit(LatticeBuild& build, std::size_t triangle, SpringCollector& springs) {
  Lattice& lattice = build.lattice;
  const Triangle& t = build.surface.triangles[triangle];
  const Column& column = lattice.columns[lattice.num_vertices + triangle];
  const double factor = build.stiffness_factor(t);
  const double pillar_mm3 = column.area_mm2 * column.depth_mm;
  for (std::size_t layer = 0; layer < build.options.layers.size(); ++layer) {
    const TissueLayer& tissue = build.options.layers[layer];
    const double volume = pillar_mm3 * (tissue.bottom_share - build.share_above(layer));
    const double mass = build.options.density_kg_per_mm3 * volume;
    const int lower = column.nodes[layer];
    if (layer > 0) {
      constexpr double kSpringsPerLink = 4.0;  // one down, three neighbours' halves
      springs.add(column.nodes[layer - 1], lower, volume / kSpringsPerLink, tissue, factor);
      lattice.mass_kg[column.nodes[layer - 1]] += 0.5 * mass;
      lattice.mass_kg[lower] += 0.5 * mass;
      continue;
    }
    constexpr double kSpringsPerUnit = 6.0;  // three edges, three legs
    for (int c = 0; c < 3; ++c) {
      springs.add(t[c], t[(c + 1) % 3], volume / kSpringsPerUnit, tissue, factor);
      springs.add(t[c], lower, volume / kSpringsPerUnit, tissue, factor);
      lattice.mass_kg[t[c]] += mass / 4.0;
    }
    lattice.mass_kg[lower] += mass / 4.0;
    if (column.is_thin() || tissue.bulk_ratio <= 0.0) continue;
    Prism unit{{t[0], t[1], t[2], lower, lower, lower}, 0.0, 0.0};
    unit.rest_mm3 = signed_volume(unit, lattice.rest_mm);
    unit.bulk_kpa = factor * tissue.bulk_ratio * tissue.modulus_kpa;
    lattice.prisms.push_back(unit);
  }
}

// Between the chains of two triangles that share an edge: along every layer, and struts across.
void add_links(LatticeBuild& build, std::size_t one, std::size_t other, SpringCollector& springs) {
  constexpr double kShare = 1.0 / 12.0;  // of the two pillars, for each of the springs of a link
  Lattice& lattice = build.lattice;
  const Column& a = lattice.columns[lattice.num_vertices + one];
  const Column& b = lattice.columns[lattice.num_vertices + other];
  const double factor = 0.5 * (build.stiffness_factor(build.surface.triangles[one]) +
                               build.stiffness_factor(build.surface.triangles[other]));
  for (std::size_t layer = 1; layer < build.options.layers.size(); ++layer) {
    const TissueLayer& tissue = build.options.layers[layer];
    const double share = tissue.bottom_share - build.share_above(layer);
    const double volume = kShare * share * (a.area_mm2 * a.depth_mm + b.area_mm2 * b.depth_mm);
    springs.add(a.nodes[layer - 1], b.nodes[layer - 1], volume, tissue, factor);
    springs.add(a.nodes[layer - 1], b.nodes[layer], volume, tissue, factor);
    springs.add(a.nodes[layer], b.nodes[layer - 1], volume, tissue, factor);
  }
}

}  // namespace

void build_centroids(LatticeBuild& build) {
  add_nodes(build);
  Lattice& lattice = build.lattice;
  lattice.mass_kg.assign(lattice.rest_mm.size(), 0.0);
  SpringCollector springs(lattice, build.options);
  std::map<std::array<int, 2>, std::size_t> first_of_edge;
  for (std::size_t t = 0; t < build.surface.triangles.size(); ++t) {
    add_unit(build, t, springs);
    for (int e = 0; e < 3; ++e) {
      const int a = build.surface.triangles[t][e];
      const int b = build.surface.triangles[t][(e + 1) % 3];
      const auto [at, fresh] = first_of_edge.try_emplace({std::min(a, b), std::max(a, b)}, t);
      if (!fresh) add_links(build, at->second, t, springs);
    }
  }
  add_epidermis(build, springs);
  springs.finish();
}

}  // namespace zygoma
