// The layered tissue lattice (paper, section 3 and figure 2) as data: nodes, springs, prisms.
//
// The surface mesh is extruded inwards, one node layer after the other: epidermis, dermis/fat
// interface, fascia, bone. A *column* is the chain of nodes below one surface vertex; node index =
// layer * num_columns + column. Between two node layers every triangle makes a triangular prism.
// Springs run along the edges of every node layer, down the columns, and across both diagonals of
// every side quad (cross struts). The layers are a list, so two of them are the bi-layer model.
//
// Stiffness is calibrated: a spring of length L that stands for the share V of tissue of modulus E
// has alpha = E V / L^2, so that refining the mesh does not change the face.
//
// Lengths and volumes at rest come from the mesh itself: zero input gives exactly the input mesh.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "face/anatomy.h"
#include "face/tissue.h"

namespace zygoma {

// Tissue between two node layers.
struct TissueLayer {
  std::string name;
  double bottom_share = 1.0;  // of the tissue depth; the last layer ends at 1 = bone
  double modulus_kpa = 10.0;  // E; only ratios between layers and muscles matter
  double stiff_ratio = 1.0;   // beta / alpha; 1 = single phase, 10+ makes Newton work hard
  double bulk_ratio = 8.0;    // K / E; below 3 tissue loses volume, above 20 Newton crawls
};

struct LatticeOptions {
  std::vector<TissueLayer> layers{
      {"dermis", 0.22, 30.0, 4.0, 5.0},
      {"fat", 0.67, 10.0, 4.0, 8.0},
      {"muscle", 1.0, 4.0, 1.0, 18.0},
  };
  double epidermis_modulus_kpa = 120.0;
  double epidermis_thickness_mm = 0.15;
  double epidermis_stiff_ratio = 2.0;
  // Volume of a prism against base area x height, below which the tissue is thinned on the spot
  // (concave and strongly curved places). [0.05, 0.8]; lower risks inverted elements at rest.
  double smallest_fill = 0.35;
};

struct Prism {
  std::array<int, 6> node{};  // upper triangle counter-clockwise from outside, then lower
  double rest_mm3 = 0.0;
  double bulk_kpa = 0.0;
};

struct Lattice {
  int num_columns = 0;
  int num_node_layers = 0;  // bone is the last
  std::vector<Vec3> rest_mm;
  std::vector<Spring> springs;
  std::vector<Prism> prisms;
  std::vector<double> depth_mm;             // per column, as built
  std::vector<double> area_mm2;             // per column, share of the surface
  std::vector<std::array<int, 2>> edges;    // of the surface, first < second
  std::vector<std::vector<int>> neighbors;  // columns next to a column, ascending

  // Too thin for volume to mean anything: no prisms there, and muscles hold it throughout.
  bool is_thin(int column) const { return depth_mm[column] < kThinMm; }
  static constexpr double kThinMm = 1.5;
  double mean_depth_mm(const Triangle& t) const {
    return (depth_mm[t[0]] + depth_mm[t[1]] + depth_mm[t[2]]) / 3.0;
  }

  int num_free_nodes() const { return (num_node_layers - 1) * num_columns; }
  int fascia_node(int column) const { return (num_node_layers - 2) * num_columns + column; }
  int bone_node(int column) const { return num_free_nodes() + column; }
};

// Throws InputError naming the vertex or triangle if the surface cannot carry tissue.
Lattice make_lattice(const Anatomy& anatomy, const LatticeOptions& options = {});

// Unit normals of the surface, each averaged `rounds` times with its neighbours.
std::vector<Vec3> smooth_normals(const SurfaceMesh& surface,
                                 const std::vector<std::vector<int>>& neighbors,
                                 int rounds);

}  // namespace zygoma
