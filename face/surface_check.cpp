#include "face/surface_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <string>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kSmallestFaceMm = 20.0;  // across the corners of its box
constexpr double kLargestFaceMm = 2000.0;
constexpr double kClearlyOutside = 0.02;  // share of the flow through a piece that is not chance

using Edge = std::array<int, 2>;

Edge undirected(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

std::string name_of(const Edge& e) {
  return "surface edge " + std::to_string(e[0]) + "-" + std::to_string(e[1]);
}

std::string vertex_name(std::size_t v) { return "surface vertex " + std::to_string(v); }
std::string triangle_name(std::size_t t) { return "surface triangle " + std::to_string(t); }

// Groups that grow together.
class Groups {
 public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  void join(int a, int b) { parent_[std::max(find(a), find(b))] = std::min(find(a), find(b)); }

 private:
  std::vector<int> parent_;
};

// The mesh while it is repaired. Vertices keep the numbers of the input until the end, triangles
// too: one that is dropped is marked by {-1, -1, -1}.
struct Repair {
  const SurfaceMesh& input;
  const SurfaceCheckOptions& options;
  std::vector<Triangle> triangles;
  std::vector<int> same_as;  // per vertex: the first one at its place
  CheckedSurface result;

  const Vec3& at(int v) const { return input.positions_mm[v]; }
  bool is_dropped(std::size_t t) const { return triangles[t][0] < 0; }
  void drop(std::size_t t) {
    triangles[t] = {-1, -1, -1};
    ++result.dropped_triangles;
  }
  // Triangles at every edge.
  std::map<Edge, std::vector<int>> edges() const {
    std::map<Edge, std::vector<int>> all;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (is_dropped(t)) continue;
      for (int e = 0; e < 3; ++e) {
        all[undirected(triangles[t][e], triangles[t][(e + 1) % 3])].push_back(static_cast<int>(t));
      }
    }
    return all;
  }
};

void check_input(const SurfaceMesh& surface, const std::vector<Region>& region) {
  const std::size_t n = surface.positions_mm.size();
  require(n >= 3 && !surface.triangles.empty(), "surface: empty, expected a triangle mesh");
  require(region.empty() || region.size() == n,
          "region: " + std::to_string(region.size()) + " values, expected one per vertex (" +
              std::to_string(n) + ")");
  Eigen::AlignedBox3d box;
  for (std::size_t v = 0; v < n; ++v) {
    require(surface.positions_mm[v].allFinite(), vertex_name(v) + ": not finite");
    box.extend(surface.positions_mm[v]);
  }
  const double size = box.diagonal().norm();
  require(size >= kSmallestFaceMm && size <= kLargestFaceMm,
          "surface: " + std::to_string(size) + " mm across, expected a face in millimetres");
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const int v : surface.triangles[t]) {
      require(v >= 0 && v < static_cast<int>(n),
              triangle_name(t) + ": vertex " + std::to_string(v) + ", expected 0 to " +
                  std::to_string(n - 1));
    }
  }
}

// Two flaps of one slit touch where it is closed and are not one for that.
bool across_a_slit(Region a, Region b) {
  const auto is = [&](Region upper, Region lower) {
    return (a == upper && b == lower) || (a == lower && b == upper);
  };
  return is(Region::kUpperLip, Region::kLowerLip) || is(Region::kUpperLid, Region::kLowerLid);
}

void merge_vertices(Repair& repair, const std::vector<Region>& region) {
  const double reach = repair.options.coincident_mm;
  const int n = static_cast<int>(repair.input.positions_mm.size());
  std::vector<int> by_x(n);
  std::iota(by_x.begin(), by_x.end(), 0);
  std::sort(by_x.begin(), by_x.end(), [&](int a, int b) {
    return std::pair(repair.at(a).x(), a) < std::pair(repair.at(b).x(), b);
  });
  Groups groups(n);
  for (int k = 0; k < n; ++k) {
    const int v = by_x[k];
    for (int other = k + 1; other < n; ++other) {
      const int u = by_x[other];
      if (repair.at(u).x() - repair.at(v).x() > reach) break;
      if ((repair.at(u) - repair.at(v)).norm() > reach) continue;
      if (region.empty() || !across_a_slit(region[v], region[u])) groups.join(v, u);
    }
  }
  for (int v = 0; v < n; ++v) {
    repair.same_as.push_back(groups.find(v));
    repair.result.merged_vertices += repair.same_as[v] != v;
  }
  for (std::size_t t = 0; t < repair.triangles.size(); ++t) {
    Triangle& tri = repair.triangles[t];
    for (int& v : tri) v = repair.same_as[v];
    if (tri[0] == tri[1] || tri[1] == tri[2] || tri[2] == tri[0]) repair.drop(t);
  }
}

// Flips the edge of a triangle that has its third vertex on it, which takes the triangle away
// without leaving a crack in its neighbour. At a border it is just dropped.
void flatten_cap(Repair& repair, std::size_t t, int corner) {
  const int on_edge = repair.triangles[t][corner];
  const int a = repair.triangles[t][(corner + 1) % 3];
  const int b = repair.triangles[t][(corner + 2) % 3];
  const auto edges = repair.edges();
  const std::vector<int>& at_edge = edges.at(undirected(a, b));
  if (at_edge.size() == 1) {
    repair.drop(t);
    return;
  }
  const int neighbor = at_edge[0] == static_cast<int>(t) ? at_edge[1] : at_edge[0];
  Triangle& other = repair.triangles[neighbor];
  const auto opposite =
      std::find_if(other.begin(), other.end(), [&](int v) { return v != a && v != b; });
  const int c = *opposite;
  const bool same_sense = other[(opposite - other.begin() + 1) % 3] == b;
  require(at_edge.size() == 2 && same_sense && !edges.contains(undirected(on_edge, c)),
          triangle_name(t) + ": no area, and its neighbours leave no way to repair it");
  repair.triangles[t] = {on_edge, a, c};
  other = {on_edge, c, b};
  ++repair.result.flipped_edges;
}

// The corner of a triangle that lies on the edge across, -1 if the triangle is no sliver. Rejects
// needles, two corners of which are nearly at one place: which of them counts is not known.
int corner_on_edge(const Repair& repair, std::size_t t) {
  const Triangle& tri = repair.triangles[t];
  std::array<double, 3> edge;  // opposite to the corners
  for (int c = 0; c < 3; ++c) {
    edge[c] = (repair.at(tri[(c + 1) % 3]) - repair.at(tri[(c + 2) % 3])).norm();
  }
  const int corner = static_cast<int>(std::max_element(edge.begin(), edge.end()) - edge.begin());
  const Vec3& from = repair.at(tri[(corner + 1) % 3]);
  const Vec3 along = repair.at(tri[(corner + 2) % 3]) - from;
  const Vec3 to_tip = repair.at(tri[corner]) - from;
  const double height = along.cross(to_tip).norm() / edge[corner];
  if (height * repair.options.largest_aspect > edge[corner]) return -1;
  const double place = along.dot(to_tip) / along.squaredNorm();
  require(place > 0.01 && place < 0.99,
          triangle_name(t) + ": a sliver, " + std::to_string(edge[corner]) + " mm long and " +
              std::to_string(height) + " mm high");
  return corner;
}

void repair_slivers(Repair& repair) {
  constexpr int kMostRounds = 20;  // several vertices on one edge take a flip each
  for (int round = 0;; ++round) {
    bool found = false;
    for (std::size_t t = 0; t < repair.triangles.size(); ++t) {
      if (repair.is_dropped(t)) continue;
      const int corner = corner_on_edge(repair, t);
      if (corner < 0) continue;
      require(round < kMostRounds, triangle_name(t) + ": no area, and no flip of edges helps");
      flatten_cap(repair, t, corner);
      found = true;
    }
    if (!found) return;
  }
}

// Surface at every edge and around every vertex, one sense of turning throughout.
void check_manifold(const Repair& repair, const std::map<Edge, std::vector<int>>& edges) {
  std::set<Edge> directed;
  for (const auto& [edge, triangles] : edges) {
    require(triangles.size() <= 2,
            name_of(edge) + ": used by " + std::to_string(triangles.size()) +
                " triangles, expected at most two");
  }
  for (std::size_t t = 0; t < repair.triangles.size(); ++t) {
    if (repair.is_dropped(t)) continue;
    for (int e = 0; e < 3; ++e) {
      const Edge edge{repair.triangles[t][e], repair.triangles[t][(e + 1) % 3]};
      require(directed.insert(edge).second,
              triangle_name(t) + ": turns the other way than its neighbour across " +
                  name_of(undirected(edge[0], edge[1])));
    }
  }
}

// The triangles around a vertex must hang together by edges, else two fans touch in a point.
void check_fans(const Repair& repair, const std::map<Edge, std::vector<int>>& edges) {
  // Corners of triangles, 3 triangle + corner, that an edge joins.
  Groups fans(3 * repair.triangles.size());
  const auto corner = [&](int t, int v) {
    const Triangle& tri = repair.triangles[t];
    return 3 * t + static_cast<int>(std::find(tri.begin(), tri.end(), v) - tri.begin());
  };
  for (const auto& [edge, triangles] : edges) {
    if (triangles.size() != 2) continue;
    for (const int v : edge) fans.join(corner(triangles[0], v), corner(triangles[1], v));
  }
  std::map<int, int> fan_of;  // by vertex
  for (std::size_t t = 0; t < repair.triangles.size(); ++t) {
    if (repair.is_dropped(t)) continue;
    for (const int v : repair.triangles[t]) {
      const int fan = fans.find(corner(static_cast<int>(t), v));
      require(fan_of.try_emplace(v, fan).first->second == fan,
              vertex_name(v) + ": pieces of surface touch in this point only");
    }
  }
}

// Turns pieces that are inside out: what flows out of the middle of a face flows out through it.
void turn_outward(Repair& repair, Groups& pieces) {
  std::map<int, std::vector<int>> triangles_of;
  for (std::size_t t = 0; t < repair.triangles.size(); ++t) {
    if (!repair.is_dropped(t)) {
      triangles_of[pieces.find(repair.triangles[t][0])].push_back(static_cast<int>(t));
    }
  }
  repair.result.pieces = static_cast<int>(triangles_of.size());
  require(repair.result.pieces == 1 || repair.options.several_pieces,
          "surface: " + std::to_string(repair.result.pieces) + " pieces, expected one; " +
              vertex_name((++triangles_of.begin())->first) + " belongs to the second");
  for (const auto& [first, triangles] : triangles_of) {
    std::vector<std::array<Vec3, 2>> parts;  // middle and area of each triangle
    Vec3 middle = Vec3::Zero();
    double area = 0.0;
    for (const int t : triangles) {
      const auto& [a, b, c] = repair.triangles[t];
      parts.push_back({(repair.at(a) + repair.at(b) + repair.at(c)) / 3.0,
                       0.5 * (repair.at(b) - repair.at(a)).cross(repair.at(c) - repair.at(a))});
      middle += parts.back()[1].norm() * parts.back()[0];
      area += parts.back()[1].norm();
    }
    middle /= area;
    double flow = 0.0;
    double most = 0.0;
    double forward = 0.0;
    for (const auto& [at, across] : parts) {
      flow += across.dot(at - middle);
      most += across.norm() * (at - middle).norm();
      forward += across.z();
    }
    const bool clear = std::abs(flow) > kClearlyOutside * most;
    require(clear || forward > 0.0,
            "surface: the piece of " + vertex_name(first) +
                " is flat and faces backwards; expected the outside to be forward (+z)");
    if (!clear || flow > 0.0) continue;
    for (const int t : triangles) std::swap(repair.triangles[t][1], repair.triangles[t][2]);
    ++repair.result.turned_pieces;
  }
}

int count_borders(const std::map<Edge, std::vector<int>>& edges, std::size_t num_vertices) {
  Groups borders(num_vertices);
  std::set<int> on_border;
  for (const auto& [edge, triangles] : edges) {
    if (triangles.size() != 1) continue;
    borders.join(edge[0], edge[1]);
    on_border.insert(edge.begin(), edge.end());
  }
  std::set<int> loops;
  for (const int v : on_border) loops.insert(borders.find(v));
  return static_cast<int>(loops.size());
}

// Numbers what is left.
void renumber(Repair& repair) {
  const std::size_t n = repair.input.positions_mm.size();
  std::vector<char> used(n, 0);
  for (const Triangle& t : repair.triangles) {
    if (t[0] >= 0) used[t[0]] = used[t[1]] = used[t[2]] = 1;
  }
  CheckedSurface& result = repair.result;
  result.vertex_of.assign(n, -1);
  for (std::size_t v = 0; v < n; ++v) {
    const int first = repair.same_as[v];
    if (!used[first]) {
      ++result.dropped_vertices;
    } else if (first != static_cast<int>(v)) {
      result.vertex_of[v] = result.vertex_of[first];
    } else {
      result.vertex_of[v] = static_cast<int>(result.mesh.positions_mm.size());
      result.mesh.positions_mm.push_back(repair.at(first));
    }
  }
  for (const auto& [a, b, c] : repair.triangles) {
    if (a < 0) continue;
    result.mesh.triangles.push_back(
        {result.vertex_of[a], result.vertex_of[b], result.vertex_of[c]});
  }
}

}  // namespace

CheckedSurface checked_surface(const SurfaceMesh& surface,
                               const std::vector<Region>& region,
                               const SurfaceCheckOptions& options) {
  check_input(surface, region);
  Repair repair{surface, options, surface.triangles, {}, {}};
  merge_vertices(repair, region);
  repair_slivers(repair);
  const auto edges = repair.edges();
  require(!edges.empty(), "surface: no triangle with an area is left");
  check_manifold(repair, edges);
  check_fans(repair, edges);
  Groups pieces(surface.positions_mm.size());
  for (const auto& [edge, triangles] : edges) pieces.join(edge[0], edge[1]);
  turn_outward(repair, pieces);
  repair.result.borders = count_borders(edges, surface.positions_mm.size());
  renumber(repair);
  return std::move(repair.result);
}

}  // namespace zygoma
