#include "face/head_mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace zygoma {
namespace {

constexpr double kTop = 203.0;
constexpr double kSide = 172.0;
constexpr double kBottom = -172.0;
constexpr double kCrown = 20.0;  // above: the outline is an ellipse

// Wanted spacing of the mesh relative to its finest.
double relative_spacing(const HeadShape& shape, const Vec2& p) {
  const double x = std::abs(p.x());
  const double mouth = std::hypot(std::max(0.0, x - 22.0), 0.8 * (p.y() + 69.0));
  const double eye = std::hypot(0.6 * (x - 34.0), p.y() - 2.0);
  const double nose = std::hypot(std::max(0.0, x - 8.0), 0.7 * (p.y() + 42.0));
  double s = 1.0 + 0.055 * std::max(0.0, mouth - 9.0);
  s = std::min(s, 1.0 + 0.055 * std::max(0.0, eye - 8.0));
  s = std::min(s, 1.15 + 0.07 * std::max(0.0, nose - 6.0));
  if (x < 70.0) s = std::min(s, 2.4 + 0.08 * std::abs(p.y() - shape.hairline(x)));
  return std::min(s, 4.6);
}

// Wanted spacing. The tissue shears most at the corner of the mouth when the jaw opens: however
// coarse the mesh, elements there stay small, or they turn inside out.
double spacing_mm(const HeadShape& shape, const Vec2& p, double finest) {
  constexpr double kAtCorner = 4.0;
  const Vec2 corner(shape.mouth_corner_x(), shape.mouth_rim(shape.mouth_corner_x(), 0));
  const double off = (Vec2(std::abs(p.x()), p.y()) - corner).norm();
  return std::min(finest * relative_spacing(shape, p), kAtCorner + 0.3 * off);
}

bool in_outline(const Vec2& p) {
  if (p.x() < 0.0 || p.x() > kSide || p.y() < kBottom) return false;
  const double up = std::max(0.0, (p.y() - kCrown) / (kTop - kCrown));
  return std::pow(p.x() / kSide, 2.0) + up * up < 1.0;
}

bool in_openings(const HeadShape& shape, const Vec2& p) {
  const double x = p.x();
  if (x < shape.mouth_corner_x() && p.y() < shape.mouth_rim(x, +1) &&
      p.y() > shape.mouth_rim(x, -1)) {
    return true;
  }
  return x > shape.eye_inner_x() && x < shape.eye_outer_x() && p.y() < shape.eye_rim(x, +1) &&
         p.y() > shape.eye_rim(x, -1);
}

bool in_domain(const HeadShape& shape, const Vec2& p) {
  return in_outline(p) && !in_openings(shape, p);
}

// Walks a polyline so that steps are about the wanted spacing; both ends included.
std::vector<Vec2> spaced(const HeadShape& shape, const std::vector<Vec2>& line, double finest) {
  std::vector<double> count(line.size(), 0.0);  // steps needed up to here
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double h = spacing_mm(shape, 0.5 * (line[i] + line[i - 1]), finest);
    count[i] = count[i - 1] + (line[i] - line[i - 1]).norm() / h;
  }
  const int steps = std::max(2, static_cast<int>(std::lround(count.back())));
  std::vector<Vec2> result{line.front()};
  std::size_t i = 1;
  for (int k = 1; k < steps; ++k) {
    const double want = count.back() * k / steps;
    while (count[i] < want) ++i;
    const double t = (want - count[i - 1]) / (count[i] - count[i - 1]);
    result.push_back(line[i - 1] + t * (line[i] - line[i - 1]));
  }
  result.push_back(line.back());
  return result;
}

std::vector<Vec2> straight(const Vec2& a, const Vec2& b) {
  std::vector<Vec2> line;
  for (int i = 0; i <= 200; ++i) line.push_back(a + (b - a) * (i / 200.0));
  return line;
}

struct HalfPoints {
  std::vector<DomainPoint> points;
  int num_fixed = 0;
};

void add(HalfPoints& half, const Vec2& p, Rim rim = Rim::kNone, int side = 0) {
  half.points.push_back({p, rim, side, 0.0});
}

// A rim from corner to corner (or midline to corner) with the same stations above and below, and a
// ring of points around it.
void add_rim(HalfPoints& half, const HeadShape& shape, Rim rim, double finest) {
  const bool eye = rim == Rim::kEye;
  const double first = eye ? shape.eye_inner_x() : 0.0;
  const double last = eye ? shape.eye_outer_x() : shape.mouth_corner_x();
  const auto y = [&](double x, int side) {
    return eye ? shape.eye_rim(x, side) : shape.mouth_rim(x, side);
  };
  std::vector<Vec2> upper;
  for (int i = 0; i <= 200; ++i) {
    const double x = first + (last - first) * (0.5 - 0.5 * std::cos(M_PI * i / 200.0));
    upper.push_back({x, y(x, +1)});
  }
  std::vector<Vec2> stations = spaced(shape, upper, 0.85 * finest);
  std::vector<Vec2> around;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double x = stations[i].x();
    const double ring = 0.8 * spacing_mm(shape, {x, y(x, +1)}, finest);
    const bool corner = (eye && i == 0) || i + 1 == stations.size();
    if (corner) {
      add(half, {x, y(x, +1)}, rim, 0);
      around.push_back({x + (i == 0 ? -ring : ring), y(x, +1)});
      continue;
    }
    for (const int side : {+1, -1}) {
      add(half, {x, y(x, side)}, rim, side);
      const double slope = (y(x + 0.3, side) - y(x - 0.3, side)) / 0.6;
      Vec2 normal(x == 0.0 ? 0.0 : -side * slope, side);
      around.push_back(Vec2(x, y(x, side)) + ring * normal.normalized());
    }
  }
  for (const Vec2& p : around) {
    if (p.x() >= 0.0 && in_domain(shape, p)) add(half, p);
  }
}

HalfPoints border_points(const HeadShape& shape, double finest) {
  HalfPoints half;
  add_rim(half, shape, Rim::kMouth, finest);
  add_rim(half, shape, Rim::kEye, finest);
  const double ring = 0.8 * spacing_mm(shape, {0.0, shape.mouth_rim(0.0, +1)}, finest);
  const auto add_inner =
      [&](const std::vector<Vec2>& line, std::size_t skip_front, std::size_t skip_back) {
        const std::vector<Vec2> points = spaced(shape, line, finest);
        for (std::size_t i = skip_front; i + skip_back < points.size(); ++i) add(half, points[i]);
      };
  add_inner(straight({0.0, shape.mouth_rim(0.0, +1) + ring}, {0.0, kTop}), 1, 0);
  add_inner(straight({0.0, kBottom}, {0.0, shape.mouth_rim(0.0, -1) - ring}), 0, 1);
  add_inner(straight({0.0, kBottom}, {kSide, kBottom}), 1, 0);
  add_inner(straight({kSide, kBottom}, {kSide, kCrown}), 1, 1);
  std::vector<Vec2> arc;
  for (int i = 0; i <= 300; ++i) {
    const double a = 0.5 * M_PI * i / 300.0;
    arc.push_back({kSide * std::cos(a), kCrown + (kTop - kCrown) * std::sin(a)});
  }
  add_inner(arc, 0, 1);
  half.num_fixed = static_cast<int>(half.points.size());
  return half;
}

double hashed(std::uint32_t i) {  // [-1, 1), the same everywhere
  i = (i ^ 61U) ^ (i >> 16U);
  i *= 9U;
  i ^= i >> 4U;
  i *= 0x27d4eb2dU;
  i ^= i >> 15U;
  return static_cast<double>(i) / 2147483648.0 - 1.0;
}

// Poisson disks of graded radius from a fixed pseudo-random sequence.
void fill(HalfPoints& half, const HeadShape& shape, double finest) {
  const double area = kSide * (kTop - kBottom);
  const int tries = static_cast<int>(12.0 * area / (finest * finest));
  for (int i = 0; i < tries; ++i) {
    const Vec2 p(0.5 * kSide * (1.0 + hashed(2 * i + 1)),
                 kBottom + 0.5 * (kTop - kBottom) * (1.0 + hashed(2 * i + 2)));
    if (!in_domain(shape, p)) continue;
    const double radius = 0.78 * spacing_mm(shape, p, finest);
    const bool is_free =
        std::none_of(half.points.begin(), half.points.end(), [&](const DomainPoint& q) {
          return (q.at_mm - p).squaredNorm() < radius * radius;
        });
    if (is_free) add(half, p);
  }
}

struct Circle {
  Vec2 centre{0.0, 0.0};
  double squared_radius = 0.0;
};

Circle circumcircle(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a;
  const Vec2 ac = c - a;
  const double d = 2.0 * (ab.x() * ac.y() - ab.y() * ac.x());
  const Vec2 offset((ac.y() * ab.squaredNorm() - ab.y() * ac.squaredNorm()) / d,
                    (ab.x() * ac.squaredNorm() - ac.x() * ab.squaredNorm()) / d);
  return {a + offset, offset.squaredNorm()};
}

// Bowyer and Watson: every new point digs out the triangles whose circle holds it.
std::vector<Triangle> delaunay(std::vector<Vec2> points) {
  const int n = static_cast<int>(points.size());
  for (int i = 0; i < n; ++i) {  // no four points on one circle
    points[i] += 1e-6 * Vec2(hashed(2 * i + 77), hashed(2 * i + 78));
  }
  points.insert(points.end(), {Vec2(-3e3, -2e3), Vec2(3e3, -2e3), Vec2(0.0, 4e3)});
  std::vector<Triangle> triangles{{n, n + 1, n + 2}};
  std::vector<Circle> circles{circumcircle(points[n], points[n + 1], points[n + 2])};
  std::vector<std::pair<int, int>> hole;
  for (int i = 0; i < n; ++i) {
    hole.clear();
    for (std::size_t t = 0; t < triangles.size();) {
      if ((points[i] - circles[t].centre).squaredNorm() >= circles[t].squared_radius) {
        ++t;
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        const std::pair<int, int> twin(triangles[t][(k + 1) % 3], triangles[t][k]);
        const auto found = std::find(hole.begin(), hole.end(), twin);
        if (found != hole.end()) {
          hole.erase(found);
        } else {
          hole.emplace_back(twin.second, twin.first);
        }
      }
      triangles[t] = triangles.back();
      triangles.pop_back();
      circles[t] = circles.back();
      circles.pop_back();
    }
    for (const auto& [a, b] : hole) {
      triangles.push_back({a, b, i});
      circles.push_back(circumcircle(points[a], points[b], points[i]));
    }
  }
  return triangles;
}

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

std::vector<Triangle> inner_triangles(const HeadShape& shape, const HalfPoints& half) {
  std::vector<Vec2> at;
  for (const DomainPoint& p : half.points) at.push_back(p.at_mm);
  const int n = static_cast<int>(at.size());
  std::vector<Triangle> inside;
  for (const Triangle& t : delaunay(at)) {
    if (t[0] >= n || t[1] >= n || t[2] >= n) continue;
    const Vec2 middle = (at[t[0]] + at[t[1]] + at[t[2]]) / 3.0;
    if (twice_area(at[t[0]], at[t[1]], at[t[2]]) < 1e-3) continue;
    // Triangles between two rim points of one opening bridge the opening.
    const auto on_rim = [&](int v) { return half.points[v].rim != Rim::kNone; };
    if (on_rim(t[0]) && on_rim(t[1]) && on_rim(t[2])) continue;
    if (in_domain(shape, middle)) inside.push_back(t);
  }
  return inside;
}

// Springs that only push, a little longer than the wanted spacing.
void relax(HalfPoints& half, const HeadShape& shape, double finest) {
  constexpr int kRounds = 48;
  std::vector<std::pair<int, int>> edges;
  for (int round = 0; round < kRounds; ++round) {
    if (round % 4 == 0) {
      edges.clear();
      for (const Triangle& t : inner_triangles(shape, half)) {
        for (int k = 0; k < 3; ++k) {
          edges.emplace_back(std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]));
        }
      }
      std::sort(edges.begin(), edges.end());
      edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    }
    std::vector<Vec2> force(half.points.size(), Vec2::Zero());
    for (const auto& [a, b] : edges) {
      const Vec2 between = half.points[b].at_mm - half.points[a].at_mm;
      const double length = between.norm();
      const Vec2 middle = 0.5 * (half.points[b].at_mm + half.points[a].at_mm);
      const double push = std::max(0.0, 1.15 * spacing_mm(shape, middle, finest) - length);
      force[a] -= push / length * between;
      force[b] += push / length * between;
    }
    for (std::size_t i = half.num_fixed; i < half.points.size(); ++i) {
      const Vec2 p = half.points[i].at_mm;
      const double longest = 0.3 * spacing_mm(shape, p, finest);
      Vec2 step = 0.2 * force[i];
      if (step.norm() > longest) step *= longest / step.norm();
      if (in_domain(shape, p + step)) half.points[i].at_mm = p + step;
    }
  }
}

DomainMesh mirrored(const HalfPoints& half, const std::vector<Triangle>& triangles) {
  DomainMesh mesh;
  mesh.points = half.points;
  const int n = static_cast<int>(half.points.size());
  mesh.mirror.resize(n);
  for (int i = 0; i < n; ++i) {
    if (half.points[i].at_mm.x() == 0.0) {
      mesh.mirror[i] = i;
      continue;
    }
    DomainPoint other = half.points[i];
    other.at_mm.x() = -other.at_mm.x();
    mesh.mirror[i] = static_cast<int>(mesh.points.size());
    mesh.points.push_back(other);
    mesh.mirror.push_back(i);
  }
  mesh.triangles = triangles;
  for (const Triangle& t : triangles) {
    mesh.triangles.push_back({mesh.mirror[t[0]], mesh.mirror[t[2]], mesh.mirror[t[1]]});
  }
  return mesh;
}

using Edge = std::pair<int, int>;

// Directed edges without a twin.
std::vector<Edge> border_edges(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> seen;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) seen[{t[k], t[(k + 1) % 3]}] = 1;
  }
  std::vector<Edge> border;
  for (const auto& [edge, one] : seen) {
    if (!seen.contains({edge.second, edge.first})) border.push_back(edge);
  }
  return border;
}

// The strip behind every rim: one more row of vertices.
void sew_strips(DomainMesh& mesh) {
  std::map<int, int> behind;
  const std::vector<Edge> border = border_edges(mesh.triangles);
  for (const auto& [a, b] : border) {
    for (const int v : {a, b}) {
      if (mesh.points[v].rim == Rim::kNone || behind.contains(v)) continue;
      DomainPoint p = mesh.points[v];
      p.inward = 1.0;
      behind[v] = static_cast<int>(mesh.points.size());
      mesh.points.push_back(p);
    }
  }
  mesh.mirror.resize(mesh.points.size());
  for (const auto& [v, inner] : behind) mesh.mirror[inner] = behind.at(mesh.mirror[v]);
  for (const auto& [a, b] : border) {
    if (!behind.contains(a) || !behind.contains(b)) continue;
    const int c = behind.at(a);
    const int d = behind.at(b);
    // The diagonals are mirrored too.
    if (mesh.points[a].at_mm.x() + mesh.points[b].at_mm.x() > 0.0) {
      mesh.triangles.push_back({b, a, c});
      mesh.triangles.push_back({b, c, d});
    } else {
      mesh.triangles.push_back({b, a, d});
      mesh.triangles.push_back({a, c, d});
    }
  }
}

DomainMesh mesh_with_spacing(const HeadShape& shape, double finest) {
  HalfPoints half = border_points(shape, finest);
  fill(half, shape, finest);
  relax(half, shape, finest);
  DomainMesh mesh = mirrored(half, inner_triangles(shape, half));
  sew_strips(mesh);
  return mesh;
}

DomainPoint midpoint(const HeadShape& shape, const DomainPoint& a, const DomainPoint& b) {
  DomainPoint m;
  m.at_mm = 0.5 * (a.at_mm + b.at_mm);
  const bool same_eye = a.at_mm.x() * b.at_mm.x() > 0.0 || a.rim == Rim::kMouth;
  if (a.rim == Rim::kNone || a.rim != b.rim || !same_eye) return m;
  m.rim = a.rim;
  m.side = a.side != 0 ? a.side : b.side;
  m.inward = 0.5 * (a.inward + b.inward);
  const double x = std::abs(m.at_mm.x());
  if (m.side != 0) {
    m.at_mm.y() = m.rim == Rim::kEye ? shape.eye_rim(x, m.side) : shape.mouth_rim(x, m.side);
  }
  return m;
}

struct Neighbourhood {
  std::vector<int> around;        // sorted
  std::vector<int> along_border;  // the two border neighbours
};

Stencil even_stencil(int v, const Neighbourhood& near) {
  if (near.along_border.size() == 2) {
    return {{v, 0.75}, {near.along_border[0], 0.125}, {near.along_border[1], 0.125}};
  }
  const double n = static_cast<double>(near.around.size());
  const double c = 0.375 + 0.25 * std::cos(2.0 * M_PI / n);
  const double beta = (0.625 - c * c) / n;  // Loop 1987
  Stencil stencil{{v, 1.0 - n * beta}};
  for (const int u : near.around) stencil.push_back({u, beta});
  return stencil;
}

}  // namespace

Vec2 outline_point(double s) {
  constexpr double kArcShare = 0.58;
  if (s > kArcShare) {
    return {kSide, kCrown + (kBottom - kCrown) * (s - kArcShare) / (1.0 - kArcShare)};
  }
  const double a = 0.5 * M_PI * (1.0 - s / kArcShare);
  return {s > 0.0 ? kSide * std::cos(a) : 0.0, kCrown + (kTop - kCrown) * std::sin(a)};
}

DomainMesh mesh_domain(const HeadShape& shape, int num_vertices) {
  // The number of vertices goes with the inverse square of the spacing.
  double finest = 4.2 * std::sqrt(700.0 / num_vertices);
  DomainMesh mesh = mesh_with_spacing(shape, finest);
  for (int i = 0; i < 3; ++i) {
    const double ratio = static_cast<double>(mesh.points.size()) / num_vertices;
    if (std::abs(ratio - 1.0) < 0.03) break;
    finest *= std::pow(ratio, 0.55);
    mesh = mesh_with_spacing(shape, finest);
  }
  return mesh;
}

DomainMesh subdivide(const HeadShape& shape,
                     const DomainMesh& mesh,
                     std::vector<Stencil>& stencils) {
  const int n = static_cast<int>(mesh.points.size());
  std::map<Edge, std::vector<int>> opposite;  // of undirected edges
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      opposite[std::minmax(t[k], t[(k + 1) % 3])].push_back(t[(k + 2) % 3]);
    }
  }
  std::vector<Neighbourhood> near(n);
  for (const auto& [edge, corners] : opposite) {
    near[edge.first].around.push_back(edge.second);
    near[edge.second].around.push_back(edge.first);
    if (corners.size() == 1) {
      near[edge.first].along_border.push_back(edge.second);
      near[edge.second].along_border.push_back(edge.first);
    }
  }
  DomainMesh fine;
  fine.points = mesh.points;
  stencils.clear();
  for (int v = 0; v < n; ++v) stencils.push_back(even_stencil(v, near[v]));
  std::map<Edge, int> middle;
  for (const auto& [edge, corners] : opposite) {
    const auto& [a, b] = edge;
    middle[edge] = static_cast<int>(fine.points.size());
    fine.points.push_back(midpoint(shape, mesh.points[a], mesh.points[b]));
    if (corners.size() == 2) {
      stencils.push_back({{a, 0.375}, {b, 0.375}, {corners[0], 0.125}, {corners[1], 0.125}});
    } else {
      stencils.push_back({{a, 0.5}, {b, 0.5}});
    }
  }
  fine.mirror = mesh.mirror;
  for (const auto& [edge, m] : middle) {
    fine.mirror.push_back(
        middle.at(std::minmax(mesh.mirror[edge.first], mesh.mirror[edge.second])));
  }
  for (const Triangle& t : mesh.triangles) {
    std::array<int, 3> m{};
    for (int k = 0; k < 3; ++k) m[k] = middle.at(std::minmax(t[k], t[(k + 1) % 3]));
    fine.triangles.push_back({t[0], m[0], m[2]});
    fine.triangles.push_back({t[1], m[1], m[0]});
    fine.triangles.push_back({t[2], m[2], m[1]});
    fine.triangles.push_back({m[0], m[1], m[2]});
  }
  return fine;
}

}  // namespace zygoma
