#include "face/generic_head.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include "face/lattice.h"
#include "face/simulator.h"
#include "src/base/check.h"
#include "tests/support/shape_parameters.h"

namespace zygoma {
namespace {

const Anatomy& default_head() {
  static const Anatomy anatomy = make_generic_head();
  return anatomy;
}

using Place = std::tuple<double, double, double>;

Place place(const Vec3& p) { return {p.x() + 0.0, p.y(), p.z()}; }
Place mirrored(const Vec3& p) { return {-p.x() + 0.0, p.y(), p.z()}; }

void expect_mirror_image(const SurfaceMesh& mesh) {
  std::set<Place> places;
  for (const Vec3& p : mesh.positions_mm) places.insert(place(p));
  for (const Vec3& p : mesh.positions_mm) {
    ASSERT_TRUE(places.contains(mirrored(p))) << p.transpose();
  }
  std::set<std::array<Place, 3>> triangles;
  const auto sorted = [](std::array<Place, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  const auto corner = [&](const Triangle& t, int k) { return mesh.positions_mm[t[k]]; };
  for (const Triangle& t : mesh.triangles) {
    triangles.insert(sorted({place(corner(t, 0)), place(corner(t, 1)), place(corner(t, 2))}));
  }
  for (const Triangle& t : mesh.triangles) {
    ASSERT_TRUE(triangles.contains(
        sorted({mirrored(corner(t, 0)), mirrored(corner(t, 1)), mirrored(corner(t, 2))})));
  }
}

struct BorderLoop {
  int num_vertices = 0;
  Vec3 middle{0.0, 0.0, 0.0};
};

// Checks that the mesh is an oriented manifold and returns its borders.
std::vector<BorderLoop> borders(const SurfaceMesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  std::map<int, int> next;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1) << "two triangles run through an edge in the same direction";
    if (edges.contains({edge.second, edge.first})) continue;
    EXPECT_FALSE(next.contains(edge.first)) << "two borders touch in a vertex";
    next[edge.first] = edge.second;
  }
  std::vector<BorderLoop> loops;
  while (!next.empty()) {
    BorderLoop loop;
    int v = next.begin()->first;
    while (next.contains(v)) {
      loop.middle += mesh.positions_mm[v];
      ++loop.num_vertices;
      const int following = next[v];
      next.erase(v);
      v = following;
    }
    loop.middle /= loop.num_vertices;
    loops.push_back(loop);
  }
  return loops;
}

double smallest_angle_deg(const SurfaceMesh& mesh) {
  double smallest = 180.0;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.positions_mm[t[(k + 1) % 3]] - mesh.positions_mm[t[k]];
      const Vec3 b = mesh.positions_mm[t[(k + 2) % 3]] - mesh.positions_mm[t[k]];
      smallest = std::min(smallest, std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI);
    }
  }
  return smallest;
}

TEST(GenericHead, IsItsOwnMirrorImageToTheBit) {
  expect_mirror_image(default_head().surface);
  expect_mirror_image(default_head().skin.mesh);
}

TEST(GenericHead, SurfaceIsAManifoldOpenOnlyAtMouthEyesAndOutline) {
  for (const int n : {300, 700, 2000}) {
    const Anatomy head = make_generic_head({}, {n, 0, 64});
    const std::vector<BorderLoop> loops = borders(head.surface);
    ASSERT_EQ(loops.size(), 4U) << n;
    int eyes = 0;
    int mouths = 0;
    for (const BorderLoop& loop : loops) {
      if (loop.middle.z() < -30.0) continue;  // the outline
      if (std::abs(loop.middle.y()) < 10.0 && std::abs(std::abs(loop.middle.x()) - 31.5) < 4.0) {
        ++eyes;
      }
      if (std::abs(loop.middle.y() + 69.0) < 5.0 && std::abs(loop.middle.x()) < 1.0) ++mouths;
    }
    EXPECT_EQ(eyes, 2) << n;
    EXPECT_EQ(mouths, 1) << n;
    EXPECT_NEAR(static_cast<double>(head.surface.positions_mm.size()), n, 0.1 * n);
  }
}

TEST(GenericHead, TrianglesAreWellShaped) {
  EXPECT_GT(smallest_angle_deg(default_head().surface), 8.0);
  EXPECT_GT(smallest_angle_deg(default_head().skin.mesh), 1.5);
  for (const SurfaceMesh* mesh : {&default_head().surface, &default_head().skin.mesh}) {
    for (const Triangle& t : mesh->triangles) {
      const Vec3& a = mesh->positions_mm[t[0]];
      const double area =
          0.5 * (mesh->positions_mm[t[1]] - a).cross(mesh->positions_mm[t[2]] - a).norm();
      EXPECT_GT(area, 1e-3);
    }
  }
}

TEST(GenericHead, EveryVertexHasTissueAndAShareOfTheJaw) {
  const Anatomy& head = default_head();
  const std::size_t n = head.surface.positions_mm.size();
  ASSERT_EQ(head.tissue_depth_mm.size(), n);
  ASSERT_EQ(head.mandible_weight.size(), n);
  ASSERT_EQ(head.region.size(), n);
  for (std::size_t v = 0; v < n; ++v) {
    const Vec3& p = head.surface.positions_mm[v];
    EXPECT_GT(head.tissue_depth_mm[v], 1.0);
    EXPECT_LT(head.tissue_depth_mm[v], 16.0);
    EXPECT_GE(head.mandible_weight[v], 0.0);
    EXPECT_LE(head.mandible_weight[v], 1.0);
    if (p.y() > 0.0) {
      EXPECT_EQ(head.mandible_weight[v], 0.0);
    }
    if (std::abs(p.x()) < 15.0 && p.y() < -85.0 && p.y() > -105.0 && p.z() > 0.0) {
      EXPECT_GT(head.mandible_weight[v], 0.95) << p.transpose();
    }
    if (head.region[v] == Region::kUpperLip) {
      EXPECT_LT(head.mandible_weight[v], 0.6);
    }
  }
  for (const Region region :
       {Region::kUpperLip, Region::kLowerLip, Region::kUpperLid, Region::kLowerLid}) {
    EXPECT_GT(std::count(head.region.begin(), head.region.end(), region), 4);
  }
}

TEST(GenericHead, EmbeddingRowsSumToOneAndKeepTheSkinAtRest) {
  const Anatomy& head = default_head();
  const Embedding& embedding = head.skin.embedding;
  const std::size_t n = head.skin.mesh.positions_mm.size();
  ASSERT_EQ(embedding.begin.size(), n + 1);
  ASSERT_EQ(embedding.index.size(), embedding.weight.size());
  const std::vector<Vec3>& rest = head.surface.positions_mm;
  for (std::size_t v = 0; v < n; ++v) {
    double sum = 0.0;
    Vec3 p = head.skin.mesh.positions_mm[v];
    for (int k = embedding.begin[v]; k < embedding.begin[v + 1]; ++k) {
      ASSERT_GE(embedding.index[k], 0);
      ASSERT_LT(embedding.index[k], static_cast<int>(rest.size()));
      sum += static_cast<double>(embedding.weight[k]);
      p += static_cast<double>(embedding.weight[k]) *
           (rest[embedding.index[k]] - rest[embedding.index[k]]);
    }
    ASSERT_NEAR(sum, 1.0, 1e-6);
    ASSERT_EQ(p, head.skin.mesh.positions_mm[v]);
  }
}

TEST(GenericHead, SkinIsFinerThanTheSurface) {
  const std::size_t coarse = default_head().surface.triangles.size();
  EXPECT_EQ(default_head().skin.mesh.triangles.size(), 16 * coarse);
  EXPECT_EQ(default_head().skin.uv.size(), default_head().skin.mesh.positions_mm.size());
  for (const Eigen::Vector2f& uv : default_head().skin.uv) {
    EXPECT_GE(uv.minCoeff(), 0.0F);
    EXPECT_LE(uv.maxCoeff(), 1.0F);
  }
}

const NamedCurve& curve(const Anatomy& head, const std::string& name) {
  for (const NamedCurve& c : head.curves) {
    if (c.name == name) return c;
  }
  throw std::runtime_error("no curve " + name);
}

TEST(GenericHead, CurvesAreAllThereAndRunAsTheSchemaSays) {
  const Anatomy& head = default_head();
  const std::vector<std::string> names{"brow_left",
                                       "brow_right",
                                       "furrow_left",
                                       "furrow_right",
                                       "nose_tip",
                                       "upper_lip",
                                       "lower_lip",
                                       "chin_boss",
                                       "hairline",
                                       "eyelid_left",
                                       "eyelid_right"};
  ASSERT_EQ(head.curves.size(), names.size());
  const auto at = [&](int v) { return head.skin.mesh.positions_mm[v]; };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const NamedCurve& c = head.curves[i];
    EXPECT_EQ(c.name, names[i]);
    ASSERT_GE(c.skin_vertices.size(), 9U) << c.name;
    const std::set<int> distinct(c.skin_vertices.begin(), c.skin_vertices.end());
    EXPECT_EQ(distinct.size(), c.skin_vertices.size()) << c.name;
    for (std::size_t k = 0; k + 1 < c.skin_vertices.size(); ++k) {
      const double step = (at(c.skin_vertices[k + 1]) - at(c.skin_vertices[k])).norm();
      EXPECT_LT(step, 8.0) << c.name << " " << k;
    }
    const Vec3 first = at(c.skin_vertices.front());
    const Vec3 last = at(c.skin_vertices.back());
    if (c.name == "brow_left") {
      EXPECT_GT(first.x(), 0.0);
      EXPECT_GT(last.x(), first.x() + 30.0);
    } else if (c.name == "brow_right") {
      EXPECT_LT(first.x(), 0.0);
      EXPECT_LT(last.x(), first.x() - 30.0);
    } else if (c.name == "furrow_left" || c.name == "furrow_right") {
      EXPECT_EQ(first.x() > 0.0, c.name == "furrow_left");
      EXPECT_GT(first.y(), last.y() + 20.0);
    } else if (c.name == "eyelid_left" || c.name == "eyelid_right") {
      const double side = c.name == "eyelid_left" ? 1.0 : -1.0;
      EXPECT_GT(side * first.x(), 0.0) << c.name;
      EXPECT_GT(side * last.x(), side * first.x() + 20.0) << c.name;
      const Vec3 middle = at(c.skin_vertices[c.skin_vertices.size() / 2]);
      EXPECT_GT(middle.y(), 0.5 * (first.y() + last.y()) + 2.0) << c.name;
    } else {
      // From the subject's right to left, and symmetric.
      EXPECT_LT(first.x(), 0.0) << c.name;
      EXPECT_EQ(first.x(), -last.x()) << c.name;
      EXPECT_EQ(first.y(), last.y()) << c.name;
    }
  }
  // Both lips end in the same corners.
  EXPECT_EQ(curve(head, "upper_lip").skin_vertices.front(),
            curve(head, "lower_lip").skin_vertices.front());
  EXPECT_EQ(curve(head, "upper_lip").skin_vertices.back(),
            curve(head, "lower_lip").skin_vertices.back());
}

TEST(GenericHead, MusclesComeInMirroredPairs) {
  const Anatomy& head = default_head();
  ASSERT_GT(head.muscles.size(), 10U);
  for (const Muscle& muscle : head.muscles) {
    if (!muscle.name.ends_with("_L")) continue;
    const int other = head.muscle_index(muscle.name.substr(0, muscle.name.size() - 1) + "R");
    ASSERT_GE(other, 0) << muscle.name;
    EXPECT_NEAR(muscle.attachment_mm.x(), -head.muscles[other].attachment_mm.x(), 1e-6);
    EXPECT_NEAR(muscle.attachment_mm.y(), head.muscles[other].attachment_mm.y(), 1e-6);
  }
}

TEST(GenericHead, EveryShapeParameterChangesTheHeadAtBothEndsOfItsRange) {
  const std::vector<test_support::ShapeParameter>& parameters = test_support::shape_parameters();
  const HeadOptions coarse{700, 0, 64};
  const Anatomy standard = make_generic_head({}, coarse);
  const std::size_t n = standard.surface.positions_mm.size();
  std::vector<std::vector<Vec3>> ways;  // in which they change it
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    for (const double value : {parameters[i].low, parameters[i].high}) {
      Identity identity;
      identity.*parameters[i].value = value;
      const Anatomy other = make_generic_head(identity, coarse);
      ASSERT_EQ(other.surface.positions_mm.size(), n);
      double largest = 0.0;
      std::vector<Vec3> way;
      for (std::size_t v = 0; v < n; ++v) {
        way.push_back(other.surface.positions_mm[v] - standard.surface.positions_mm[v]);
        largest = std::max(largest, way.back().norm());
      }
      EXPECT_GT(largest, 1.2) << i << " at " << value;
      EXPECT_LT(largest, 30.0) << i << " at " << value;
      expect_mirror_image(other.surface);
      // It can still carry tissue.
      EXPECT_NO_THROW(make_lattice(other)) << i << " at " << value;
      if (value == parameters[i].high) ways.push_back(way);
    }
  }
  // No two of them do the same.
  for (std::size_t i = 0; i < ways.size(); ++i) {
    for (std::size_t k = i + 1; k < ways.size(); ++k) {
      double ii = 0.0, kk = 0.0, ik = 0.0;
      for (std::size_t v = 0; v < n; ++v) {
        ii += ways[i][v].squaredNorm();
        kk += ways[k][v].squaredNorm();
        ik += ways[i][v].dot(ways[k][v]);
      }
      EXPECT_LT(std::abs(ik) / std::sqrt(ii * kk), 0.9) << i << " and " << k;
    }
  }
}

TEST(GenericHead, SeedAndStubbleChangeThePaintAndNothingElse) {
  const HeadOptions coarse{700, 0, 128};
  const Anatomy standard = make_generic_head({}, coarse);
  EXPECT_EQ(make_generic_head({}, coarse).skin.albedo.rgb, standard.skin.albedo.rgb);
  Identity seed;
  seed.texture_seed = 7;
  Identity stubble;
  stubble.stubble = 1.0;
  for (const Identity& identity : {seed, stubble}) {
    const Anatomy other = make_generic_head(identity, coarse);
    EXPECT_NE(other.skin.albedo.rgb, standard.skin.albedo.rgb);
    EXPECT_EQ(other.surface.positions_mm, standard.surface.positions_mm);
  }
}

TEST(GenericHead, RefusesValuesOutOfRangeByName) {
  const auto message = [](const Identity& identity, const HeadOptions& options) -> std::string {
    try {
      make_generic_head(identity, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  Identity identity;
  identity.nose_width = 3.0;
  EXPECT_NE(message(identity, {}).find("nose_width is 3"), std::string::npos);
  identity = {};
  identity.brow_height_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(identity, {}).find("brow_height_mm"), std::string::npos);
  identity = {};
  identity.skin_tone.y() = 1.5F;
  EXPECT_NE(message(identity, {}).find("skin_tone"), std::string::npos);
  EXPECT_NE(message({}, {200, 1}).find("num_surface_vertices is 200"), std::string::npos);
  EXPECT_NE(message({}, {700, 5}).find("skin_levels is 5"), std::string::npos);
}

// Neck and scalp end where the head was cut off; mouth and eyes end by nature.
TEST(GenericHead, TissueGoesOnBeyondTheCut) {
  const auto head = std::make_shared<const Anatomy>(
      make_generic_head({}, {.num_surface_vertices = 300, .skin_levels = 0, .albedo_size_px = 64}));
  // Against the bone below.
  const auto rim_slips_mm = [&](double rim_hold_ratio) {
    TissueModel tissue;
    tissue.lattice.layers = bi_layer();
    tissue.muscles.rim_hold_ratio = rim_hold_ratio;
    Simulator face(head, tissue);
    FaceState state = face.rest();
    const std::vector<double> relaxed(head->muscles.size(), 0.0);
    EXPECT_TRUE(face.settle({relaxed, 0.5 * head->jaw.full_rad}, state).converged);
    const Lattice& lattice = face.lattice();
    const auto moved = [&](int node) -> Vec3 {
      return state.positions_mm[node] - lattice.rest_mm[node];
    };
    double most = 0.0;
    for (std::size_t v = 0; v < head->cut_off.size(); ++v) {
      if (!head->cut_off[v]) continue;
      const int bone = lattice.columns[lattice.column_of[v]].bone();
      most = std::max(most, (moved(static_cast<int>(v)) - moved(bone)).norm());
    }
    return most;
  };
  const double held = rim_slips_mm(1.0);
  EXPECT_LT(held, 0.4);
  EXPECT_GT(rim_slips_mm(0.0), 3.0 * held);
  for (std::size_t v = 0; v < head->cut_off.size(); ++v) {
    EXPECT_FALSE(head->cut_off[v] && head->region[v] != Region::kFace);
  }
}

}  // namespace
}  // namespace zygoma
