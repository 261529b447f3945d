// The layered tissue lattice (paper, sections 3 and 5, figure 2) as data: nodes, springs, elements.
//
// Two ways to hang tissue below a surface mesh, of any number of layers:
//
// kPrisms: the mesh is extruded inwards, one node layer after the other. Between two node layers
//   every triangle makes a triangular prism; springs run along its edges and across both diagonals
//   of its sides (cross struts). Three layers (epidermis | dermis | fat | muscle | bone) are the
//   tri-layer model, two the bi-layer model.
// kCentroids: section 5 to the letter. Below the centre of gravity of every triangle hangs a
//   chain of nodes; the first forms a tetrahedral unit with the triangle. Springs run along
//   the triangle's edges, the three legs of the unit, down the chain, and between
//   neighbouring chains with cross struts. Only the tetrahedra keep their volume:
//   nothing else there is an element.
//
// A *column* is the chain of nodes below one point of the surface. Nodes are numbered free ones
// first (the surface mesh's vertices at their head), bone last.
//
// Stiffness is calibrated by default: a spring of length L that stands for the share V of tissue of
// modulus E has alpha = E V / L^2, so that refining the mesh does not change the face. With
// constants, as in the paper, alpha is the same for every spring of a layer.
//
// Lengths and volumes at rest come from the mesh itself: zero input gives exactly the input mesh.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "face/anatomy.h"
#include "face/prism.h"
#include "face/tissue.h"

namespace zygoma {

enum class Topology { kPrisms, kCentroids };
enum class Stiffness { kCalibrated, kConstant };

// Tissue between two node layers.
struct TissueLayer {
  std::string name;
  double bottom_share = 1.0;      // of the tissue depth; the last layer ends at 1 = bone
  double modulus_kpa = 10.0;      // E; only ratios between layers and muscles matter at equilibrium
  double stiff_ratio = 1.0;       // beta / alpha; 1 = single phase, 10+ makes Newton work hard
  double bulk_ratio = 8.0;        // K / E; below 3 tissue loses volume, above 20 Newton crawls
  double alpha_mn_per_mm = 10.0;  // of every spring, where stiffness is constant
  bool operator==(const TissueLayer&) const = default;
};

std::vector<TissueLayer> tri_layer();  // dermis, fat, muscle
std::vector<TissueLayer> bi_layer();   // skin, muscle: cheaper (paper, section 3c)

struct LatticeOptions {
  Topology topology = Topology::kPrisms;
  Stiffness stiffness = Stiffness::kCalibrated;
  SpringLaw law = SpringLaw::kSmooth;
  std::vector<TissueLayer> layers = tri_layer();
  double epidermis_modulus_kpa = 120.0;
  double epidermis_thickness_mm = 0.15;
  double epidermis_stiff_ratio = 2.0;
  double epidermis_alpha_mn_per_mm = 60.0;  // where stiffness is constant
  // Factor on the stiffness of the tissue below each Region, (0, 100].
  std::array<double, 5> region_stiffness{1.0, 1.0, 1.0, 1.0, 1.0};
  double density_kg_per_mm3 = 1.05e-6;
  // Volume of a prism against base area x height, below which the tissue is thinned on the spot
  // (concave and strongly curved places). [0.05, 0.8]; lower risks inverted elements at rest.
  double smallest_fill = 0.35;

  // Throws InputError naming the first value outside its range.
  void check() const;
};

struct Column {
  std::array<int, 3> vertex{};  // of the surface, whose weighted mean the column hangs below
  Vec3 weight = Vec3::UnitX();
  std::vector<int> nodes;  // from the surface down
  bool on_bone = true;     // the last node is bone, the one before fascia
  double depth_mm = 0.0;   // as built
  double area_mm2 = 0.0;   // share of the surface

  int fascia() const { return nodes[nodes.size() - 2]; }
  int bone() const { return nodes.back(); }
  // Too thin for volume to mean anything: no prisms there, and muscles hold it throughout.
  bool is_thin() const { return depth_mm < kThinMm; }
  static constexpr double kThinMm = 1.5;
};

struct Lattice {
  int num_vertices = 0;  // of the surface = nodes of the epidermis
  int num_free_nodes = 0;
  std::vector<Vec3> rest_mm;    // per node
  std::vector<double> mass_kg;  // per node
  std::vector<int> column_of;   // per node
  std::vector<Column> columns;
  std::vector<Spring> springs;
  std::vector<Prism> prisms;
  std::vector<std::array<int, 2>> edges;    // of the surface, first < second
  std::vector<std::vector<int>> neighbors;  // surface vertices next to one, ascending

  bool is_free(int node) const { return node < num_free_nodes; }
  // A field over the surface vertices, below a column.
  template <typename T>
  T below(const std::vector<T>& field, const Column& column) const {
    T sum = column.weight[0] * field[column.vertex[0]];
    for (int k = 1; k < 3; ++k) {
      if (column.weight[k] != 0.0) sum += column.weight[k] * field[column.vertex[k]];
    }
    return sum;
  }
};

// Throws InputError naming the vertex, triangle or option if the surface cannot carry tissue.
Lattice make_lattice(const Anatomy& anatomy, const LatticeOptions& options = {});

// A third of the triangles around each vertex, mm^2.
std::vector<double> vertex_areas(const SurfaceMesh& surface);

// Unit normals of the surface, each averaged `rounds` times with its neighbours.
std::vector<Vec3> smooth_normals(const SurfaceMesh& surface,
                                 const std::vector<std::vector<int>>& neighbors,
                                 int rounds);

}  // namespace zygoma
