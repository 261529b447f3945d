// Surfaces that are not as they should be: HC-18, HC-19, and faces that are no faces in
// millimetres: HC-21.
#include <gtest/gtest.h>

#include <limits>

#include "face/surface_check.h"
#include "src/base/check.h"
#include "tests/hard/floating_point_traps.h"
#include "tests/hard/record.h"
#include "tests/hard/scenes.h"

namespace zygoma::hard {
namespace {

using HC18 = Trapped;
using HC19 = Trapped;
using HC21 = Trapped;

// Convex, with a border, 6 x 6 squares of 10 mm; `hole` leaves the middle out.
SurfaceMesh dome(bool hole = false) {
  constexpr int kCells = 6;
  SurfaceMesh mesh;
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const double x = 10.0 * i - 30.0;
      const double y = 10.0 * j - 30.0;
      mesh.positions_mm.emplace_back(x, y, -0.01 * (x * x + y * y));
    }
  }
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      if (hole && i == 2 && j == 3) continue;
      const int a = j * (kCells + 1) + i;
      const int d = a + kCells + 1;
      mesh.triangles.push_back({a, a + 1, d + 1});
      mesh.triangles.push_back({a, d + 1, d});
    }
  }
  return mesh;
}

void append(const SurfaceMesh& piece, const Vec3& shift_mm, SurfaceMesh& mesh) {
  const int first = static_cast<int>(mesh.positions_mm.size());
  for (const Vec3& p : piece.positions_mm) mesh.positions_mm.push_back(p + shift_mm);
  for (const Triangle& t : piece.triangles) {
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

void expect_rejected(const SurfaceMesh& mesh, const std::string& element, const std::string& why) {
  try {
    checked_surface(mesh);
    ADD_FAILURE() << "accepted: " << why;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(element), std::string::npos) << error.what();
    record(why,
           '"' + std::string(error.what()) + '"',
           "rejected, the element named",
           Outcome::kRefused);
  }
}

double area_of(const SurfaceMesh& mesh) {
  double area = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions_mm[t[0]];
    area += 0.5 * (mesh.positions_mm[t[1]] - a).cross(mesh.positions_mm[t[2]] - a).norm();
  }
  return area;
}

// What a repaired mesh has to be good for.
void expect_carries_tissue(const SurfaceMesh& mesh) {
  Anatomy anatomy;
  anatomy.surface = mesh;
  anatomy.tissue_depth_mm.assign(mesh.positions_mm.size(), 5.0);
  anatomy.mandible_weight.assign(mesh.positions_mm.size(), 0.0);
  anatomy.region.assign(mesh.positions_mm.size(), Region::kFace);
  for (const Prism& prism : make_lattice(anatomy).prisms) EXPECT_GT(prism.rest_mm3, 0.0);
}

TEST_F(HC18, GoodSurfacesPassUnchanged) {
  for (const SurfaceMesh& mesh : {dome(), dome(true)}) {
    const CheckedSurface checked = checked_surface(mesh);
    EXPECT_EQ(checked.mesh.positions_mm, mesh.positions_mm);
    EXPECT_EQ(checked.mesh.triangles, mesh.triangles);
    EXPECT_EQ(checked.pieces, 1);
  }
  EXPECT_EQ(checked_surface(dome(true)).borders, 2);
  // The heads of the project: holes at mouth and eyes, a border at the neck.
  const auto head = generic_head(500);
  const CheckedSurface checked = checked_surface(head->surface, head->region);
  EXPECT_EQ(checked.mesh.triangles, head->surface.triangles);
  EXPECT_GE(checked.borders, 2);
  // A closed mouth stays a mouth.
  const Anatomy patch = make_face_patch(small_patch());
  const CheckedSurface closed = checked_surface(patch.surface, patch.region);
  EXPECT_EQ(closed.merged_vertices, 0);
  EXPECT_EQ(closed.mesh.triangles, patch.surface.triangles);
  record("holes, the border at the neck, lips that touch (default head: " +
             std::to_string(checked.borders) + " borders)",
         "unchanged",
         "fine as they are");
}

TEST_F(HC18, CoincidentVerticesAreMerged) {
  // Every triangle with corners of its own, as in a bag of triangles.
  const SurfaceMesh mesh = dome();
  SurfaceMesh bag;
  for (const Triangle& t : mesh.triangles) {
    for (const int v : t) bag.positions_mm.push_back(mesh.positions_mm[v]);
    const int n = static_cast<int>(bag.positions_mm.size());
    bag.triangles.push_back({n - 3, n - 2, n - 1});
  }
  const CheckedSurface checked = checked_surface(bag);
  EXPECT_EQ(checked.mesh.positions_mm.size(), mesh.positions_mm.size());
  EXPECT_EQ(checked.mesh.triangles.size(), mesh.triangles.size());
  EXPECT_EQ(checked.borders, 1);
  for (std::size_t v = 0; v < bag.positions_mm.size(); ++v) {
    EXPECT_EQ(checked.mesh.positions_mm[checked.vertex_of[v]], bag.positions_mm[v]);
  }
  expect_carries_tissue(checked.mesh);
  record("a bag of triangles, every corner a vertex of its own",
         std::to_string(checked.merged_vertices) + " vertices merged, one surface",
         "repaired");
}

TEST_F(HC18, TrianglesWithoutAreaGoAwayWithoutACrack) {
  SurfaceMesh mesh = dome();
  const double area = area_of(mesh);
  // A triangle with twice the same vertex, and one between a vertex and its copy.
  mesh.triangles.push_back({3, 3, 4});
  mesh.positions_mm.push_back(mesh.positions_mm[10]);
  mesh.triangles.push_back({10, static_cast<int>(mesh.positions_mm.size()) - 1, 11});
  // A vertex on the edge between the first two triangles: one of them is split, and the gap to the
  // other closed by a triangle without area.
  const auto [a, b, c] = mesh.triangles[0];  // the diagonal is c-a
  const int middle = static_cast<int>(mesh.positions_mm.size());
  mesh.positions_mm.push_back(0.5 * (mesh.positions_mm[a] + mesh.positions_mm[c]));
  mesh.triangles[0] = {a, b, middle};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({a, middle, c});
  const CheckedSurface checked = checked_surface(mesh);
  EXPECT_EQ(checked.dropped_triangles, 2);
  EXPECT_EQ(checked.flipped_edges, 1);
  EXPECT_EQ(checked.borders, 1);
  EXPECT_NEAR(area_of(checked.mesh), area, 1e-9 * area);
  expect_carries_tissue(checked.mesh);
  record("triangles of no area: a vertex twice, two vertices at one place, three in a line",
         "two dropped, one edge flipped; area kept, one border",
         "repaired");
}

TEST_F(HC18, SeveralVerticesOnOneEdgeTakeAFlipEach) {
  SurfaceMesh mesh = dome();
  const double area = area_of(mesh);
  // The diagonal of the first square carries four vertices that only its left side knows of.
  const auto [a, b, c] = mesh.triangles[0];
  std::vector<int> chain{a};
  for (int k = 1; k <= 4; ++k) {
    chain.push_back(static_cast<int>(mesh.positions_mm.size()));
    mesh.positions_mm.push_back(mesh.positions_mm[a] +
                                0.2 * k * (mesh.positions_mm[c] - mesh.positions_mm[a]));
  }
  chain.push_back(c);
  mesh.triangles[0] = {a, b, chain[1]};
  for (std::size_t k = 1; k + 1 < chain.size(); ++k) {
    mesh.triangles.push_back({chain[k], b, chain[k + 1]});
    mesh.triangles.push_back({a, chain[k], chain[k + 1]});  // no area
  }
  const CheckedSurface checked = checked_surface(mesh);
  EXPECT_EQ(checked.borders, 1);
  EXPECT_NEAR(area_of(checked.mesh), area, 1e-9 * area);
  expect_carries_tissue(checked.mesh);
}

TEST_F(HC18, PiecesThatAreInsideOutAreTurned) {
  SurfaceMesh mesh = dome();
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  const CheckedSurface checked = checked_surface(mesh);
  EXPECT_EQ(checked.turned_pieces, 1);
  EXPECT_EQ(checked.mesh.triangles, dome().triangles);
  // One of two pieces, where two are allowed.
  SurfaceMesh two = dome();
  append(mesh, Vec3(100.0, 0.0, 0.0), two);
  SurfaceCheckOptions several;
  several.several_pieces = true;
  EXPECT_EQ(checked_surface(two, {}, several).turned_pieces, 1);
  record("a surface whose normals point inwards; one of two pieces", "turned", "repaired");
}

TEST_F(HC18, VerticesWithoutTriangleAreDropped) {
  SurfaceMesh mesh = dome();
  mesh.positions_mm.insert(mesh.positions_mm.begin(), Vec3(1.0, 2.0, 50.0));
  for (Triangle& t : mesh.triangles) t = {t[0] + 1, t[1] + 1, t[2] + 1};
  const CheckedSurface checked = checked_surface(mesh);
  EXPECT_EQ(checked.dropped_vertices, 1);
  EXPECT_EQ(checked.vertex_of[0], -1);
  EXPECT_EQ(checked.vertex_of[1], 0);
  EXPECT_EQ(checked.mesh.triangles, dome().triangles);
  record("a vertex without triangle", "dropped", "repaired");
}

TEST_F(HC18, WhatCannotBeRepairedIsNamed) {
  SurfaceMesh mesh = dome();
  mesh.positions_mm[7].y() = std::numeric_limits<double>::quiet_NaN();
  expect_rejected(mesh, "vertex 7", "a coordinate that is not finite");

  mesh = dome();
  mesh.triangles[3][1] = 400;
  expect_rejected(mesh, "triangle 3", "an index out of range");

  mesh = dome();
  mesh.positions_mm.emplace_back(-15.0, -25.0, 20.0);
  mesh.triangles.push_back({1, 8, static_cast<int>(mesh.positions_mm.size()) - 1});
  expect_rejected(mesh, "edge 1-8", "a fin: three triangles at one edge");

  mesh = dome();
  std::swap(mesh.triangles[20][0], mesh.triangles[20][1]);
  expect_rejected(mesh, "triangle 2", "one triangle flipped");

  mesh = dome();
  append(dome(), Vec3(100.0, 0.0, 0.0), mesh);
  expect_rejected(mesh, "vertex 49", "two pieces");

  mesh = dome();
  append(dome(), Vec3(60.0, 60.0, mesh.positions_mm[48].z() - mesh.positions_mm[0].z()), mesh);
  expect_rejected(mesh, "vertex 48", "two pieces that touch in one vertex");

  mesh = dome();
  mesh.positions_mm[24] = mesh.positions_mm[23] + Vec3(0.002, 0.0, 0.001);
  expect_rejected(
      mesh, "triangle", "slivers beyond 1:1000 between two vertices nearly at one place");

  mesh = dome();
  for (Vec3& p : mesh.positions_mm) p.z() = 0.0;
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  expect_rejected(mesh, "vertex 0", "a flat surface that faces backwards");

  expect_rejected({}, "empty", "no triangle");
}

TEST_F(HC21, AFaceInMetresIsRefused) {
  SurfaceMesh mesh = dome();
  for (Vec3& p : mesh.positions_mm) p *= 1e-3;
  expect_rejected(mesh, "millimetres", "a face in metres");
}

// Every element has volume and its lower triangle looks the same way as its upper one.
void expect_sound(const Lattice& lattice) {
  for (const Prism& prism : lattice.prisms) {
    ASSERT_GT(prism.rest_mm3, 0.0);
    const auto area = [&](int first) -> Vec3 {
      const Vec3& a = lattice.rest_mm[prism.node[first]];
      return (lattice.rest_mm[prism.node[first + 1]] - a)
          .cross(lattice.rest_mm[prism.node[first + 2]] - a);
    };
    if (prism.node[3] == prism.node[4]) continue;  // a tetrahedral unit
    ASSERT_GT(area(0).dot(area(3)), 0.0);
  }
}

TEST_F(HC19, TissueUnderConcavePlacesIsThinnedUntilItFits) {
  struct Place {
    const char* name;
    double deep_mm;
    double wide_mm;  // standard deviation
  };
  constexpr std::array<Place, 4> kPlaces{{{"nostril", 12.0, 5.0},
                                          {"eye socket", -14.0, 14.0},
                                          {"spike", 20.0, 4.0},
                                          {"pit", -20.0, 4.0}}};
  for (const Place& place : kPlaces) {
    double thinnest = 1e30;
    for (const Tissue& tissue : topologies()) {
      SCOPED_TRACE(std::string(place.name) + ", " + tissue.name);
      Anatomy anatomy = make_face_patch();
      for (Vec3& p : anatomy.surface.positions_mm) {
        const double off2 = p.x() * p.x() + std::pow(p.y() + 10.0, 2);
        p.z() += place.deep_mm * std::exp(-0.5 * off2 / (place.wide_mm * place.wide_mm));
      }
      const Lattice lattice = make_lattice(anatomy, tissue.model.lattice);
      expect_sound(lattice);
      for (const Column& column : lattice.columns) thinnest = std::min(thinnest, column.depth_mm);
    }
    record("tissue of 9 mm under a " + std::string(place.name) + " " +
               figure(std::abs(place.deep_mm)) + " mm deep or high, " + figure(place.wide_mm) +
               " mm wide, three topologies",
           "0 elements without volume; thinned to " + figure(thinnest) + " mm there",
           "number of V0 <= 0 is 0");
  }
}

TEST_F(HC19, HeadsHaveSoundTissueEverywhere) {
  int num_prisms = 0;
  for (const int num_vertices : {300, 500, 1000, 2000}) {
    const auto head = generic_head(num_vertices);
    for (const Tissue& tissue : topologies()) {
      const Lattice lattice = make_lattice(*head, tissue.model.lattice);
      expect_sound(lattice);
      num_prisms += static_cast<int>(lattice.prisms.size());
    }
  }
  record("default head of 300, 500, 1000, 2000 vertices with nostrils, lips, lids, ears",
         std::to_string(num_prisms) + " elements, all with volume",
         "number of V0 <= 0 is 0");
}

}  // namespace
}  // namespace zygoma::hard
