#include "src/render/views.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "src/base/names.h"

namespace zygoma {
namespace {

const std::vector<std::string> kNames{"front", "three-quarter", "profile", "turntable"};

double yaw_rad(View view, double turn) {
  switch (view) {
    case View::kFront:
      return 0.0;
    case View::kThreeQuarter:
      return 0.66;
    case View::kProfile:
      return 0.5 * M_PI;
    case View::kTurntable:
      break;
  }
  return 2.0 * M_PI * turn;
}

// What a turning head sweeps: a solid of revolution about the upright axis through its middle,
// without what goes on below (neck, shoulders).
struct Swept {
  Vec3 middle_mm{0.0, 0.0, 0.0};
  std::vector<Vec2> rings_mm;  // radius, height over the middle
};

Swept swept_by(const Anatomy& anatomy) {
  constexpr double kThroatY = -135.0;
  std::vector<const SurfaceMesh*> meshes{&anatomy.skin.mesh};
  for (const RigidPart& part : anatomy.rigid_parts) {
    if (part.name != "shirt") meshes.push_back(&part.mesh);
  }
  Eigen::AlignedBox3d box;
  for (const SurfaceMesh* mesh : meshes) {
    for (const Vec3& p : mesh->positions_mm) {
      if (p.y() > kThroatY) box.extend(p);
    }
  }
  Swept swept{box.center(), {}};
  for (const SurfaceMesh* mesh : meshes) {
    for (const Vec3& p : mesh->positions_mm) {
      const Vec3 off = p - swept.middle_mm;
      if (p.y() > kThroatY) swept.rings_mm.emplace_back(std::hypot(off.x(), off.z()), off.y());
    }
  }
  return swept;
}

}  // namespace

View parse_view(const std::string& text) {
  return static_cast<View>(require_name("view", kNames, text));
}

const std::vector<std::string>& view_names() { return kNames; }

const std::string& view_name(View view) { return kNames[static_cast<std::size_t>(view)]; }

Camera view_camera(View view, const Anatomy& anatomy, int width_px, int height_px, double turn) {
  constexpr double kAir = 1.03;
  constexpr double kDistance_mm = 1000.0;
  const Swept swept = swept_by(anatomy);
  // Half the picture's width and height at unit focal length, so that every ring fits: the same
  // from all sides, as a head that turns must not grow and shrink.
  double half_width = 0.0;
  double half_height = 0.0;
  for (const Vec2& ring : swept.rings_mm) {
    const double r = ring.x();
    half_width = std::max(half_width, r / std::sqrt(kDistance_mm * kDistance_mm - r * r));
    half_height = std::max(half_height, std::abs(ring.y()) / (kDistance_mm - r));
  }
  Camera camera = make_camera(width_px,
                              height_px,
                              swept.middle_mm,
                              2.0 * half_height * kDistance_mm,
                              kDistance_mm,
                              yaw_rad(view, turn));
  camera.focal_px = 0.5 / kAir * std::min(width_px / half_width, height_px / half_height);
  return camera;
}

}  // namespace zygoma
