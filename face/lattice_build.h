// What the two topologies of lattice.h share while they are built.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "face/lattice.h"

namespace zygoma {

// Springs between two nodes, with the stiffness they collect from the tissue around them.
class SpringCollector {
 public:
  SpringCollector(Lattice& lattice, const LatticeOptions& options)
      : lattice_(lattice), options_(options) {}

  // Adds volume_mm3 of a layer's tissue, of `factor` times its stiffness, to the spring i-j.
  void add(int i, int j, double volume_mm3, const TissueLayer& tissue, double factor);

  // Makes the springs, in the order of their nodes. Between two bone nodes nothing moves.
  void finish();

 private:
  struct Sum {
    double alpha = 0.0;
    double beta = 0.0;
  };
  Lattice& lattice_;
  const LatticeOptions& options_;
  std::map<std::array<int, 2>, Sum> sums_;
};

struct LatticeBuild {
  const SurfaceMesh& surface;
  const LatticeOptions& options;
  std::vector<Vec3> direction;           // per vertex, outwards: tissue extends against it
  std::vector<double> depth_mm;          // per vertex, fitted
  std::vector<double> region_stiffness;  // per vertex
  Lattice lattice;

  double share_above(std::size_t layer) const {
    return layer == 0 ? 0.0 : options.layers[layer - 1].bottom_share;
  }
  double mean(const std::vector<double>& of_vertex, const Triangle& t) const {
    return (of_vertex[t[0]] + of_vertex[t[1]] + of_vertex[t[2]]) / 3.0;
  }
  // A point of the tissue below a vertex, at a share of its depth.
  Vec3 below(int vertex, double share) const {
    return surface.positions_mm[vertex] - (share * depth_mm[vertex]) * direction[vertex];
  }
  // On the stiffness below a triangle: its regions', and the softness of thin tissue.
  double stiffness_factor(const Triangle& t) const;
};

Vec3 area_vector(const SurfaceMesh& surface, const Triangle& t);

// The epidermis is a membrane of springs along the edges: too thin for elements of its own.
void add_epidermis(const LatticeBuild& build, SpringCollector& springs);

// The share of a prism's tissue that each of its springs stands for: 6 edges, 3 verticals, 6
// struts.
void add_prism_springs(const Prism& prism,
                       const TissueLayer& tissue,
                       double factor,
                       SpringCollector& springs);

// Each fills nodes, columns, masses, prisms and springs.
void build_prisms(LatticeBuild& build);
void build_centroids(LatticeBuild& build);

}  // namespace zygoma
