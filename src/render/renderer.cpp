#include "src/render/renderer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <thread>

#include "face/furrows.h"
#include "face/jaw.h"
#include "src/render/embree.h"
#include "src/render/shading.h"
#include "src/render/skin_texture.h"

namespace zygoma {
namespace {

using Point = Eigen::Vector3f;

constexpr int kPacket = 16;
static_assert(kPacket == kLanes);
constexpr int kTile = 16;  // pixels a side
constexpr float kFar = 1e5F;

// Runs work(begin, end) over [0, count) on some threads; every item is independent of the others.
void in_parallel(int count, int num_threads, const std::function<void(int, int)>& work) {
  const int n = std::clamp(num_threads, 1, std::max(1, count));
  std::vector<std::thread> threads;
  for (int i = 1; i < n; ++i) {
    threads.emplace_back([&, i] { work(count * i / n, count * (i + 1) / n); });
  }
  work(0, count / n);
  for (std::thread& thread : threads) thread.join();
}

// Directions of a cosine-weighted hemisphere around +z, well spread (Hammersley).
std::vector<Point> hemisphere(int count) {
  std::vector<Point> directions;
  for (int i = 0; i < count; ++i) {
    double inverse = 0.0;
    for (unsigned bits = static_cast<unsigned>(i), k = 1; bits != 0; bits >>= 1U, ++k) {
      inverse += (bits & 1U) / std::pow(2.0, k);
    }
    const double r = std::sqrt((i + 0.5) / count);
    const double a = 2.0 * M_PI * inverse;
    directions.emplace_back(static_cast<float>(r * std::cos(a)),
                            static_cast<float>(r * std::sin(a)),
                            static_cast<float>(std::sqrt(1.0 - r * r)));
  }
  return directions;
}

// Two directions that make a frame with n.
void frame_of(const Point& n, Point& t, Point& b) {
  t = (std::abs(n.x()) < 0.7F ? Point::UnitX() : Point::UnitY()).cross(n).normalized();
  b = n.cross(t);
}

// Directions towards places on an area light around l.
constexpr int kLightSamples = 32;
std::array<Point, kLightSamples> places_on_light(const Point& l) {
  constexpr float kSize = 0.10F;
  Point t;
  Point b;
  frame_of(l, t, b);
  std::array<Point, kLightSamples> places;
  for (int i = 0; i < kLightSamples; ++i) {
    const float angle =
        3.14159265F * (static_cast<float>(i % 2) + static_cast<float>(i / 2) / 16.0F);
    const float radius = kSize * (0.4F + 0.6F * static_cast<float>((5 * (i / 2)) % 16) / 15.0F);
    places[i] = (l + radius * (std::cos(angle) * t + std::sin(angle) * b)).normalized();
  }
  return places;
}

void set_ray(RTCRay16& rays, int i, const Point& from, const Point& along, float near, float far) {
  rays.org_x[i] = from.x();
  rays.org_y[i] = from.y();
  rays.org_z[i] = from.z();
  rays.dir_x[i] = along.x();
  rays.dir_y[i] = along.y();
  rays.dir_z[i] = along.z();
  rays.tnear[i] = near;
  rays.tfar[i] = far;
  rays.mask[i] = 0xFFFFFFFFU;
}

struct Hit {
  int triangle = -1;
  float u = 0.0F;
  float v = 0.0F;
  float depth = 0.0F;  // mm from the camera
};

}  // namespace

struct Renderer::Impl {
  // All meshes in one: the skin first, then the rigid parts.
  struct PartRange {
    int first_vertex = 0;
    int num_vertices = 0;
    int first_triangle = 0;
    int num_triangles = 0;
    Bone bone = Bone::kSkull;
    float gloss = 0.0F;
  };

  Impl(std::shared_ptr<const Anatomy> anatomy_in, const RenderOptions& options_in);
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void load_meshes();
  void build_scene();
  void place(const std::vector<Vec3>& skin_mm, double jaw_rad);
  void compute_normals();
  void commit();
  float open_share(int vertex, const std::vector<Point>& directions, float reach) const;
  void compute_rest_ambient();
  void open_hollows();
  void cast_shadows(const Point& l);
  void cast(const float (&x)[kPacket],
            const float (&y)[kPacket],
            int count,
            Hit (&hit)[kPacket]) const;
  // Colours of up to kLanes hits.
  void shade(const Hit* hit, int count, const Shader& shader, Colour* out) const;
  SkinTexture::Texel texel_of(const Hit& hit) const;
  Point slope_of(const Triangle& triangle, const Eigen::Array2f& slope) const;
  int part_of(int triangle) const;
  void see_rows(int first, int last);
  void mark_seen();
  void colour_rows(int first, int last, const Shader& shader);
  void find_edges();
  void smooth_edges(int first, int last, const Shader& shader);
  Colour background(float y) const;
  double mm_per_px() const;  // where the head is
  void choose_texture_level();

  std::shared_ptr<const Anatomy> anatomy;
  RenderOptions options;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  RTCGeometry geometry = nullptr;
  float* buffer = nullptr;  // Embree's vertices
  int num_skin_vertices = 0;
  std::vector<PartRange> parts;
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> triangle_part;
  std::vector<int> triangles_begin;  // of a vertex, compressed rows
  std::vector<int> triangles_of;
  std::vector<int> neighbours_begin;  // of a vertex along edges, compressed rows
  std::vector<int> neighbours;
  std::vector<Point> normals;
  std::vector<float> rest_ambient;
  std::vector<std::uint8_t> in_hollow;  // vertices whose openness is found anew in each picture
  std::vector<int> in_space_order;      // vertices along a Morton curve
  std::vector<int> towards_key;         // seen, and not turned away from the key light
  std::vector<std::uint8_t> seen;       // vertices of triangles in this picture, and next to them
  std::vector<int> watched;             // seen, and in a hollow
  std::vector<float> raw_ambient;       // before it is blurred along the mesh
  std::vector<float> ambient;
  std::vector<float> key;
  std::vector<Colour> part_albedo;  // per vertex; unused for the skin
  SkinTexture texture;
  const SkinTexture::Level* level = nullptr;
  Furrows furrows;
  std::vector<float> furrow_mm;  // their amplitude, per vertex of the skin; empty = none
  float skin_level = 1.0F;       // green of the skin in the middle of the face
  ToneCurve tone;

  Camera camera;
  const SkinTint* tint = nullptr;
  Eigen::Matrix3f face_from_camera;
  Point eye = Point::Zero();
  std::vector<Hit> hits;
  std::vector<Colour> picture;
  std::vector<std::uint8_t> edge;
};

Renderer::Impl::Impl(std::shared_ptr<const Anatomy> anatomy_in, const RenderOptions& options_in)
    : anatomy(std::move(anatomy_in)),
      options(options_in),
      texture(anatomy->skin),
      furrows(anatomy->skin) {
  load_meshes();
  build_scene();
  skin_level = std::max(1e-3F, SkinTexture::at(texture.level(1e6), {0.5F, 0.5F})[1]);
  place(anatomy->skin.mesh.positions_mm, 0.0);
  compute_rest_ambient();
}

void Renderer::Impl::load_meshes() {
  const auto append = [&](const SurfaceMesh& mesh, Bone bone, float gloss) {
    PartRange range;
    range.first_vertex = static_cast<int>(points.size());
    range.num_vertices = static_cast<int>(mesh.positions_mm.size());
    range.first_triangle = static_cast<int>(triangles.size());
    range.num_triangles = static_cast<int>(mesh.triangles.size());
    range.bone = bone;
    range.gloss = gloss;
    for (const Vec3& p : mesh.positions_mm) points.push_back(p.cast<float>());
    for (const Triangle& t : mesh.triangles) {
      triangles.push_back(
          {t[0] + range.first_vertex, t[1] + range.first_vertex, t[2] + range.first_vertex});
      triangle_part.push_back(static_cast<std::uint8_t>(parts.size()));
    }
    parts.push_back(range);
  };
  append(anatomy->skin.mesh, Bone::kSkull, 0.0F);
  num_skin_vertices = static_cast<int>(points.size());
  part_albedo.assign(num_skin_vertices, Colour::Zero());
  for (const RigidPart& part : anatomy->rigid_parts) {
    append(part.mesh, part.bone, part.gloss);
    part_albedo.insert(part_albedo.end(), part.albedo.begin(), part.albedo.end());
  }
  triangles_begin.assign(points.size() + 1, 0);
  for (const Triangle& t : triangles) {
    for (const int v : t) ++triangles_begin[v + 1];
  }
  for (std::size_t v = 0; v < points.size(); ++v) triangles_begin[v + 1] += triangles_begin[v];
  std::vector<int> next(triangles_begin.begin(), triangles_begin.end() - 1);
  triangles_of.resize(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int v : triangles[t]) triangles_of[next[v]++] = static_cast<int>(t);
  }
  neighbours_begin.push_back(0);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const auto first = neighbours.end() - neighbours.begin();
    for (int k = triangles_begin[v]; k < triangles_begin[v + 1]; ++k) {
      for (const int u : triangles[triangles_of[k]]) {
        if (u == static_cast<int>(v)) continue;
        if (std::find(neighbours.begin() + first, neighbours.end(), u) == neighbours.end()) {
          neighbours.push_back(u);
        }
      }
    }
    neighbours_begin.push_back(static_cast<int>(neighbours.size()));
  }
  normals.assign(points.size(), Point::Zero());
  ambient.assign(points.size(), 1.0F);
  rest_ambient.assign(points.size(), 1.0F);
  key.assign(points.size(), 1.0F);
}

void Renderer::Impl::build_scene() {
  device = rtcNewDevice("threads=1");
  scene = rtcNewScene(device);
  // Low quality is what lets a deformed tree be refitted instead of rebuilt.
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
  geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
  buffer = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), points.size()));
  auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry,
                                                               RTC_BUFFER_TYPE_INDEX,
                                                               0,
                                                               RTC_FORMAT_UINT3,
                                                               3 * sizeof(unsigned),
                                                               triangles.size()));
  for (const Triangle& t : triangles) {
    for (const int v : t) *index++ = static_cast<unsigned>(v);
  }
  commit();
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);  // the scene keeps it
  rtcCommitScene(scene);
}

void Renderer::Impl::commit() {
  for (std::size_t v = 0; v < points.size(); ++v) {
    for (int k = 0; k < 3; ++k) buffer[3 * v + k] = points[v][k];
  }
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
}

void Renderer::Impl::place(const std::vector<Vec3>& skin_mm, double jaw_rad) {
  assert(static_cast<int>(skin_mm.size()) == num_skin_vertices);
  for (int v = 0; v < num_skin_vertices; ++v) points[v] = skin_mm[v].cast<float>();
  if (!furrows.empty()) furrows.amplitudes(skin_mm, furrow_mm);
  const Eigen::Isometry3d jaw = open_from_closed(anatomy->jaw, jaw_rad);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].bone != Bone::kMandible) continue;
    const std::vector<Vec3>& rest = anatomy->rigid_parts[i - 1].mesh.positions_mm;
    for (int v = 0; v < parts[i].num_vertices; ++v) {
      points[parts[i].first_vertex + v] = (jaw * rest[v]).cast<float>();
    }
  }
  commit();
  rtcCommitScene(scene);
  compute_normals();
}

void Renderer::Impl::compute_normals() {
  std::vector<Point> face(triangles.size());
  const auto faces = [&](int first, int last) {
    for (int t = first; t < last; ++t) {
      const auto& [a, b, c] = triangles[t];
      face[t] = (points[b] - points[a]).cross(points[c] - points[a]);
    }
  };
  const auto vertices = [&](int first, int last) {
    for (int v = first; v < last; ++v) {
      Point sum = Point::Zero();
      for (int k = triangles_begin[v]; k < triangles_begin[v + 1]; ++k)
        sum += face[triangles_of[k]];
      const float length = sum.norm();
      normals[v] = length > 0.0F ? Point(sum / length) : Point(0.0F, 0.0F, 1.0F);
    }
  };
  in_parallel(static_cast<int>(triangles.size()), options.num_threads, faces);
  in_parallel(static_cast<int>(points.size()), options.num_threads, vertices);
}

float Renderer::Impl::open_share(int vertex,
                                 const std::vector<Point>& directions,
                                 float reach) const {
  Point t;
  Point b;
  frame_of(normals[vertex], t, b);
  const Point from = points[vertex] + 0.25F * normals[vertex];
  float open = 0.0F;
  for (std::size_t first = 0; first < directions.size(); first += kPacket) {
    alignas(64) RTCRay16 rays{};
    alignas(64) int valid[kPacket];
    for (std::size_t i = 0; i < kPacket; ++i) {
      valid[i] = first + i < directions.size() ? -1 : 0;
      const Point& d = directions[std::min(first + i, directions.size() - 1)];
      const Point along = d.x() * t + d.y() * b + d.z() * normals[vertex];
      set_ray(rays, static_cast<int>(i), from, along, 0.0F, reach);
    }
    find_shadows(valid, scene, &rays, false);
    for (int i = 0; i < kPacket; ++i) {
      if (valid[i] && rays.tfar[i] >= 0.0F) open += 1.0F;
    }
  }
  return open / static_cast<float>(directions.size());
}

void Renderer::Impl::compute_rest_ambient() {
  const std::vector<Point> directions = hemisphere(32);
  in_parallel(static_cast<int>(points.size()), options.num_threads, [&](int first, int last) {
    for (int v = first; v < last; ++v) rest_ambient[v] = open_share(v, directions, 70.0F);
  });
  ambient = rest_ambient;
  raw_ambient = rest_ambient;
  constexpr float kHollow = 0.30F;
  in_hollow.resize(points.size());
  // Only the mouth opens and closes; other hollows keep what they have at rest.
  const Point mouth(0.0F, -72.0F, 0.0F);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const bool near = (points[v] - mouth).norm() < 42.0F;
    in_hollow[v] = near && rest_ambient[v] < kHollow ? 1 : 0;
  }
  // Neighbours in space next to each other in memory keep packets of shadow rays together.
  std::vector<std::pair<std::uint32_t, int>> codes;
  for (std::size_t v = 0; v < points.size(); ++v) {
    std::uint32_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const float cell = std::clamp((points[v][k] + 400.0F) / 4.0F, 0.0F, 255.0F);
      for (unsigned bit = 0; bit < 8; ++bit) {
        code |= ((static_cast<unsigned>(cell) >> bit) & 1U) << (3 * bit + static_cast<unsigned>(k));
      }
    }
    codes.emplace_back(code, static_cast<int>(v));
  }
  std::sort(codes.begin(), codes.end());
  for (const auto& [code, v] : codes) in_space_order.push_back(v);
}

void Renderer::Impl::mark_seen() {
  std::vector<std::uint8_t> hit_vertex(points.size(), 0);
  int last = -1;
  for (const Hit& hit : hits) {
    if (hit.triangle < 0 || hit.triangle == last) continue;
    last = hit.triangle;
    for (const int v : triangles[last]) hit_vertex[v] = 1;
  }
  seen.assign(points.size(), 0);
  for (const Triangle& t : triangles) {
    if (!hit_vertex[t[0]] && !hit_vertex[t[1]] && !hit_vertex[t[2]]) continue;
    for (const int v : t) seen[v] = 1;
  }
  watched.clear();
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (seen[v] && in_hollow[v]) watched.push_back(static_cast<int>(v));
  }
}

// How open the hollows in sight are, found anew.
void Renderer::Impl::open_hollows() {
  static const std::vector<Point> few = hemisphere(8);
  constexpr float kMouthReach = 13.0F;  // light bounces about in a mouth: only near things shade
  in_parallel(static_cast<int>(watched.size()), options.num_threads, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      raw_ambient[watched[i]] = open_share(watched[i], few, kMouthReach);
  });
  // Blurred along the mesh, to hide how few the rays are.
  for (const int v : watched) {
    float sum = 2.0F * raw_ambient[v];
    for (int k = neighbours_begin[v]; k < neighbours_begin[v + 1]; ++k) {
      sum += raw_ambient[neighbours[k]];
    }
    ambient[v] = sum / (2.0F + static_cast<float>(neighbours_begin[v + 1] - neighbours_begin[v]));
  }
}

// The share of the key light that reaches each vertex in sight, by two rays to places on it: the
// same ones in every picture, others than the neighbours'.
void Renderer::Impl::cast_shadows(const Point& l) {
  constexpr float kShadowReach = 200.0F;  // mm: from the head onto the shoulders
  constexpr int kRays = 2;
  constexpr int kVertices = kPacket / kRays;  // in a packet
  towards_key.clear();
  for (const int v : in_space_order) {
    if (seen[v] && normals[v].dot(l) > -0.15F) towards_key.push_back(v);
  }
  const std::array<Point, kLightSamples> samples = places_on_light(l);
  const int count = static_cast<int>(towards_key.size());
  std::vector<float> raw(points.size(), 0.0F);
  in_parallel((count + kVertices - 1) / kVertices, options.num_threads, [&](int first, int last) {
    for (int g = first; g < last; ++g) {
      alignas(64) RTCRay16 rays{};
      alignas(64) int valid[kPacket];
      for (int i = 0; i < kPacket; ++i) {
        const int item = g * kVertices + i % kVertices;
        valid[i] = item < count ? -1 : 0;
        const int v = towards_key[std::min(item, count - 1)];
        const Point from = points[v] + 0.4F * normals[v];
        const Point& d = samples[(7 * v + 5 * (i / kVertices)) % kLightSamples];
        set_ray(rays, i, from, d, 0.3F, kShadowReach);
      }
      find_shadows(valid, scene, &rays, true);
      for (int i = 0; i < kPacket; ++i) {
        if (valid[i] == 0 || rays.tfar[i] < 0.0F) continue;
        raw[towards_key[g * kVertices + i % kVertices]] += 1.0F / kRays;
      }
    }
  });
  // Blurred twice along the mesh, to hide how few they are.
  for (int round = 0; round < 2; ++round) {
    in_parallel(static_cast<int>(points.size()), options.num_threads, [&](int first, int last) {
      for (int v = first; v < last; ++v) {
        if (!seen[v]) {
          key[v] = raw[v];
          continue;
        }
        const int begin = neighbours_begin[v];
        const int end = neighbours_begin[v + 1];
        float sum = 4.0F * raw[v];
        for (int k = begin; k < end; ++k) sum += raw[neighbours[k]];
        const float weight = 4.0F + static_cast<float>(end - begin);
        key[v] = sum / weight;
      }
    });
    if (round == 0) raw.swap(key);
  }
}

void Renderer::Impl::cast(const float (&x)[kPacket],
                          const float (&y)[kPacket],
                          int count,
                          Hit (&hit)[kPacket]) const {
  alignas(64) RTCRayHit16 rays{};
  alignas(64) int valid[kPacket];
  const float half_width = 0.5F * static_cast<float>(camera.width_px - 1);
  const float half_height = 0.5F * static_cast<float>(camera.height_px - 1);
  const float per_focal = 1.0F / static_cast<float>(camera.focal_px);
  for (int i = 0; i < kPacket; ++i) {
    valid[i] = i < count ? -1 : 0;
    const Point in_camera((x[i] - half_width) * per_focal, (y[i] - half_height) * per_focal, 1.0F);
    const Point d = face_from_camera * in_camera;
    set_ray(rays.ray, i, eye, d, 0.0F, kFar);
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  find_hits(valid, scene, &rays);
  for (int i = 0; i < count; ++i) {
    const bool found = rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hit[i] = {found ? static_cast<int>(rays.hit.primID[i]) : -1,
              rays.hit.u[i],
              rays.hit.v[i],
              rays.ray.tfar[i]};
  }
}

int Renderer::Impl::part_of(int triangle) const {
  return triangle < 0 ? 255 : triangle_part[triangle];
}

SkinTexture::Texel Renderer::Impl::texel_of(const Hit& hit) const {
  const auto& [a, b, c] = triangles[hit.triangle];
  const std::vector<Eigen::Vector2f>& uv = anatomy->skin.uv;
  return SkinTexture::at(*level, (1.0F - hit.u - hit.v) * uv[a] + hit.u * uv[b] + hit.v * uv[c]);
}

// Gradient in space of a height with these slopes by u and v, on a triangle of the skin.
Point Renderer::Impl::slope_of(const Triangle& triangle, const Eigen::Array2f& slope) const {
  const auto& [a, b, c] = triangle;
  const std::vector<Eigen::Vector2f>& uv = anatomy->skin.uv;
  const Point ab = points[b] - points[a];
  const Point ac = points[c] - points[a];
  const float rise_b = slope.matrix().dot(uv[b] - uv[a]);
  const float rise_c = slope.matrix().dot(uv[c] - uv[a]);
  const Point n = ab.cross(ac);
  return n.cross(rise_c * ab - rise_b * ac) / std::max(1e-12F, n.squaredNorm());
}

void Renderer::Impl::shade(const Hit* hit, int count, const Shader& shader, Colour* out) const {
  ShadePacket packet;
  std::array<bool, kLanes> skin{};
  std::array<bool, kLanes> from_inside{};
  for (int i = 0; i < kLanes; ++i) {
    const Hit& h = hit[std::min(i, count - 1)];
    const auto& [a, b, c] = triangles[h.triangle];
    const float u = h.u;
    const float v = h.v;
    const float w = 1.0F - u - v;
    Point normal = w * normals[a] + u * normals[b] + v * normals[c];
    const Point to_camera = eye - (w * points[a] + u * points[b] + v * points[c]);
    packet.ambient[i] = w * ambient[a] + u * ambient[b] + v * ambient[c];
    packet.key[i] = options.shadows ? w * key[a] + u * key[b] + v * key[c] : 1.0F;
    const int part = triangle_part[h.triangle];
    packet.gloss[i] = parts[part].gloss;
    skin[i] = part == 0;
    constexpr float kInside = -0.12F;
    from_inside[i] =
        parts[part].gloss <= 0.0F && normal.dot(to_camera) < kInside * to_camera.norm();
    Colour albedo;
    if (skin[i]) {
      const SkinTexture::Texel texel = texel_of(h);
      albedo = texel.head<3>().matrix();
      const float furrow =
          furrow_mm.empty() ? 0.0F : w * furrow_mm[a] + u * furrow_mm[b] + v * furrow_mm[c];
      normal -= slope_of(triangles[h.triangle], texel.segment<2>(3) + furrow * texel.segment<2>(5));
      // A narrow furrow sees little of the light.
      const float depth = furrow * std::max(0.0F, -texel[7]);
      packet.ambient[i] /= 1.0F + 0.75F * depth;
      packet.key[i] /= 1.0F + 0.25F * depth;
    } else {
      albedo = w * part_albedo[a] + u * part_albedo[b] + v * part_albedo[c];
    }
    if (tint != nullptr && skin[i]) {
      const Eigen::Vector4f over = w * (*tint)[a] + u * (*tint)[b] + v * (*tint)[c];
      albedo += over.w() * (over.head<3>() - albedo);
    }
    for (int k = 0; k < 3; ++k) {
      packet.normal[k][i] = normal[k];
      packet.to_camera[k][i] = to_camera[k];
      packet.albedo[k][i] = albedo[k];
    }
  }
  for (std::array<Lanes, 3>* direction : {&packet.normal, &packet.to_camera}) {
    const Lanes per_length = dot(*direction, *direction).max(1e-12F).rsqrt();
    for (Lanes& part : *direction) part *= per_length;
  }
  // Hair is dark against the skin around it, and rough: it does not shine like skin.
  packet.shine = (1.4F / skin_level * packet.albedo[1] - 0.25F).max(0.12F).min(1.0F);
  const std::array<Lanes, 3> colour = shader(packet);
  // The inside of the head, seen through the open mouth: flesh in the dark.
  static const Colour flesh(0.020F, 0.0055F, 0.0045F);
  for (int i = 0; i < count; ++i) {
    const bool inside = from_inside[i];
    for (int k = 0; k < 3; ++k) {
      out[i][k] = inside ? packet.albedo[k][i] * flesh[k] : colour[k][i];
    }
  }
}

Colour Renderer::Impl::background(float y) const {
  const Lighting& lighting = options.lighting;
  const float t = y / static_cast<float>(std::max(1, camera.height_px - 1));
  const Colour srgb =
      lighting.background_top + t * (lighting.background_bottom - lighting.background_top);
  return srgb.cwiseProduct(srgb);  // near enough to linear light for a backdrop
}

void Renderer::Impl::see_rows(int first, int last) {
  const int width = camera.width_px;
  float x[kPacket];
  float y[kPacket];
  Hit hit[kPacket];
  for (int row = 4 * first; row < std::min(4 * last, camera.height_px); row += 4) {
    for (int column = 0; column < width; column += 4) {
      for (int i = 0; i < kPacket; ++i) {
        x[i] = static_cast<float>(std::min(column + i % 4, width - 1));
        y[i] = static_cast<float>(std::min(row + i / 4, camera.height_px - 1));
      }
      cast(x, y, kPacket, hit);
      for (int i = 0; i < kPacket; ++i) {
        if (column + i % 4 >= width || row + i / 4 >= camera.height_px) continue;
        hits[std::size_t(row + i / 4) * width + column + i % 4] = hit[i];
      }
    }
  }
}

void Renderer::Impl::colour_rows(int first, int last, const Shader& shader) {
  Hit hit[kLanes];
  Colour colour[kLanes];
  std::size_t pixels[kLanes];
  int waiting = 0;
  const auto flush = [&] {
    if (waiting == 0) return;
    shade(hit, waiting, shader, colour);
    for (int i = 0; i < waiting; ++i) picture[pixels[i]] = colour[i];
    waiting = 0;
  };
  for (int row = first; row < last; ++row) {
    const Colour behind = background(static_cast<float>(row));
    for (int column = 0; column < camera.width_px; ++column) {
      const std::size_t pixel = std::size_t(row) * camera.width_px + column;
      if (hits[pixel].triangle < 0) {
        picture[pixel] = behind;
        continue;
      }
      hit[waiting] = hits[pixel];
      pixels[waiting++] = pixel;
      if (waiting == kLanes) flush();
    }
    flush();
  }
}

// Edges: another part, another depth, or a quite different brightness, next door.
void Renderer::Impl::find_edges() {
  const int width = camera.width_px;
  const int height = camera.height_px;
  edge.assign(hits.size(), 0);
  // A surface that falls off this much from pixel to pixel ends there, or is seen from its side.
  const auto step_mm = static_cast<float>(8.0 * mm_per_px());
  const auto differs = [&](std::size_t p, std::size_t q) {
    if (part_of(hits[p].triangle) != part_of(hits[q].triangle)) return true;
    if (hits[p].triangle < 0) return false;
    if (std::abs(hits[p].depth - hits[q].depth) > step_mm) return true;
    const float a = picture[p].y();
    const float b = picture[q].y();
    return std::abs(a - b) > 0.30F * (a + b) + 0.015F;
  };
  in_parallel(height, options.num_threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      for (int column = 0; column < width; ++column) {
        const std::size_t p = std::size_t(row) * width + column;
        const bool is_edge =
            (column > 0 && differs(p, p - 1)) || (column + 1 < width && differs(p, p + 1)) ||
            (row > 0 && differs(p, p - width)) || (row + 1 < height && differs(p, p + width));
        edge[p] = is_edge ? 1 : 0;
      }
    }
  });
}

void Renderer::Impl::smooth_edges(int first, int last, const Shader& shader) {
  const int width = camera.width_px;
  const int n = std::clamp(options.samples_per_pixel, 2, kPacket);
  float x[kPacket];
  float y[kPacket];
  Hit hit[kPacket];
  Colour colour[kLanes];
  int seen_at[kPacket];  // place among those found, -1: background
  std::size_t pixels[kPacket];
  int waiting = 0;  // pixels in the packet
  const auto flush = [&] {
    cast(x, y, waiting * n, hit);
    int found = 0;
    for (int i = 0; i < waiting * n; ++i) {
      seen_at[i] = hit[i].triangle >= 0 ? found : -1;
      if (hit[i].triangle >= 0) hit[found++] = hit[i];
    }
    if (found > 0) shade(hit, found, shader, colour);
    for (int p = 0; p < waiting; ++p) {
      Colour sum = Colour::Zero();
      for (int i = p * n; i < (p + 1) * n; ++i) {
        sum += (seen_at[i] >= 0 ? colour[seen_at[i]] : background(y[i])).cwiseMin(1.2F);
      }
      picture[pixels[p]] = sum / static_cast<float>(n);
    }
    waiting = 0;
  };
  std::fill(std::begin(x), std::end(x), 0.0F);
  std::fill(std::begin(y), std::end(y), 0.0F);
  const auto add = [&](int row, int column) {
    for (int k = 0; k < n; ++k) {  // a turned grid: n rows and n columns, one sample each
      const int turned = (k * 2 + (k * 2) / n) % n;
      x[waiting * n + k] = static_cast<float>(column) - 0.5F +
                           (static_cast<float>(k) + 0.5F) / static_cast<float>(n);
      y[waiting * n + k] = static_cast<float>(row) - 0.5F +
                           (static_cast<float>(turned) + 0.5F) / static_cast<float>(n);
    }
    pixels[waiting++] = std::size_t(row) * width + column;
    if ((waiting + 1) * n > kPacket) flush();
  };
  // Tile by tile, so that the rays of a packet stay together.
  for (int top = kTile * first; top < std::min(kTile * last, camera.height_px); top += kTile) {
    const int bottom = std::min(top + kTile, camera.height_px);
    for (int left = 0; left < width; left += kTile) {
      for (int row = top; row < bottom; ++row) {
        for (int column = left; column < std::min(left + kTile, width); ++column) {
          if (edge[std::size_t(row) * width + column]) add(row, column);
        }
      }
    }
    // Never a packet across bands: which bands a thread has must not matter.
    if (waiting > 0) flush();
  }
}

double Renderer::Impl::mm_per_px() const {
  return std::abs(camera.camera_from_face.translation().z()) / camera.focal_px;
}

void Renderer::Impl::choose_texture_level() {
  // Texels per pixel where the camera looks, in the middle of the face.
  const double texels_per_mm = anatomy->skin.albedo.width / 270.0;
  level = &texture.level(0.9 * mm_per_px() * texels_per_mm);
}

Renderer::Renderer(std::shared_ptr<const Anatomy> anatomy, const RenderOptions& options)
    : impl_(std::make_unique<Impl>(std::move(anatomy), options)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::render(const std::vector<Vec3>& skin_mm,
                      double jaw_rad,
                      const Camera& camera,
                      cv::Mat& bgr,
                      const SkinTint* tint) {
  assert(tint == nullptr || tint->size() == skin_mm.size());
  Impl& r = *impl_;
  r.camera = camera;
  r.tint = tint;
  const int width = camera.width_px;
  const int height = camera.height_px;
  const Eigen::Isometry3d inverse = camera.camera_from_face.inverse();
  r.face_from_camera = inverse.linear().cast<float>();
  r.eye = inverse.translation().cast<float>();
  r.choose_texture_level();
  r.hits.resize(std::size_t(width) * height);
  r.picture.resize(std::size_t(width) * height);
  bgr.create(height, width, CV_8UC3);

  r.place(skin_mm, jaw_rad);
  const Shader shader(r.options.lighting, r.face_from_camera);
  const int threads = r.options.num_threads;
  in_parallel((height + 3) / 4, threads, [&](int a, int b) { r.see_rows(a, b); });
  r.mark_seen();
  r.open_hollows();
  if (r.options.shadows) r.cast_shadows(shader.key_direction());
  in_parallel(height, threads, [&](int a, int b) { r.colour_rows(a, b, shader); });
  if (r.options.samples_per_pixel > 1) {
    r.find_edges();
    in_parallel(
        (height + kTile - 1) / kTile, threads, [&](int a, int b) { r.smooth_edges(a, b, shader); });
  }
  in_parallel(height, threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      std::uint8_t* out = bgr.ptr<std::uint8_t>(row);
      const Colour* in = r.picture.data() + std::size_t(row) * width;
      for (int column = 0; column < width; ++column) {
        for (int k = 0; k < 3; ++k) out[3 * column + k] = r.tone(in[column][2 - k]);
      }
    }
  });
}

}  // namespace zygoma
