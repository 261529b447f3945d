#include "face/head_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "face/appearance.h"
#include "face/head_chart.h"
#include "face/head_mesh.h"

namespace zygoma {
namespace {

using Colour = Eigen::Vector3f;

Colour mix(const Colour& a, const Colour& b, double t) {
  return a + static_cast<float>(std::clamp(t, 0.0, 1.0)) * (b - a);
}

// Grid of vertices (rows x columns) joined to triangles; counter-clockwise when rows go down and
// columns to the right of the viewer... of the outside.
void join_grid(RigidPart& part, int rows, int columns, bool closed) {
  const int around = closed ? columns : columns - 1;
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c < around; ++c) {
      const int a = r * columns + c;
      const int b = r * columns + (c + 1) % columns;
      part.mesh.triangles.push_back({a, a + columns, b});
      part.mesh.triangles.push_back({b, a + columns, b + columns});
    }
  }
}

// Sphere with a cornea, rings around the direction of gaze.
RigidPart eyeball(const HeadShape& shape, bool left) {
  constexpr int kRings = 30;
  constexpr int kAround = 48;
  const EyeShape& eye = shape.eye();
  RigidPart part;
  part.name = left ? "eyeball_left" : "eyeball_right";
  part.gloss = 1.0F;
  const double iris_angle = std::asin(eye.iris_radius_mm / eye.radius_mm);
  const double pupil_angle = std::asin(2.3 / eye.radius_mm);
  const Colour white(0.66F, 0.62F, 0.59F);
  const Colour vein(0.58F, 0.36F, 0.32F);
  const Colour iris_outer(0.055F, 0.035F, 0.022F);
  const Colour iris_inner(0.20F, 0.115F, 0.055F);
  const Colour limbus(0.018F, 0.013F, 0.011F);
  const Colour black(0.004F, 0.004F, 0.004F);
  Vec3 centre = shape.eye_centre();
  for (int r = 0; r < kRings; ++r) {
    // Half of the rings inside the iris.
    const double s = r / (kRings - 1.0);
    const double angle = s < 0.6 ? 1.15 * iris_angle * s / 0.6
                                 : 1.15 * iris_angle + (1.9 - 1.15 * iris_angle) * (s - 0.6) / 0.4;
    for (int k = 0; k < kAround; ++k) {
      const double turn = 2.0 * M_PI * k / kAround;
      const double bulge =
          1.7 *
          std::pow(std::max(0.0, std::cos(0.5 * M_PI * std::min(1.0, angle / (1.25 * iris_angle)))),
                   2.0);
      const double radius = eye.radius_mm + bulge;
      Vec3 p(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle));
      Vec3 at = centre + radius * p;
      if (!left) at.x() = -at.x();
      part.mesh.positions_mm.push_back(at);
      const double t = (angle - pupil_angle) / (iris_angle - pupil_angle);
      const double streak = 0.75 + 0.25 * std::sin(17.0 * turn) * std::sin(5.0 * turn + 1.0);
      Colour colour = mix(iris_inner * static_cast<float>(streak), iris_outer, 1.25 * t - 0.15);
      colour = mix(colour, black, smooth_step(0.06, -0.06, t));
      colour = mix(colour, limbus, smooth_step(0.68, 0.92, t));
      colour = mix(colour, white, smooth_step(0.97, 1.13, t));
      colour = mix(colour, vein, 0.75 * smooth_step(iris_angle * 1.25, 1.15, angle));
      part.albedo.push_back(colour);
    }
  }
  join_grid(part, kRings, kAround, true);
  if (!left) {
    for (Triangle& t : part.mesh.triangles) std::swap(t[1], t[2]);
  }
  return part;
}

constexpr DentalArch kUpperArch{29.0, 33.0, 11.5, -71.8, 14.0};
constexpr DentalArch kLowerArch{27.0, 31.0, 9.0, -70.0, 14.0};

// A dental arch in plan, `wider` by so much: x(u), z(u), u in [-1, 1] from the subject's right to
// left.
Vec2 arch_at(double u, const DentalArch& arch, double wider_mm = 0.0) {
  const double a = 0.5 * M_PI * u;
  return {(arch.half_width_mm + wider_mm) * std::sin(a),
          arch.front_z_mm - arch.depth_mm * (1.0 - std::pow(std::cos(a), 0.8))};
}

// A row of teeth with gum: the outer face from gum to edge, round the edge and up the inner face.
RigidPart teeth(const HeadShape& shape, bool upper) {
  constexpr int kColumns = 121;
  constexpr int kOuter = 11;
  constexpr int kRows = kOuter + 5;
  RigidPart part;
  part.name = upper ? "teeth_upper" : "teeth_lower";
  part.bone = upper ? Bone::kSkull : Bone::kMandible;
  part.gloss = 0.8F;
  // Widths of the teeth from the middle outwards, millimetres along the arch.
  const std::vector<double> widths = upper
                                         ? std::vector<double>{8.6, 6.6, 7.8, 7.0, 6.8, 10.0, 10.0}
                                         : std::vector<double>{5.3, 5.8, 6.8, 7.0, 7.2, 11.0, 10.5};
  const DentalArch& arch = upper ? kUpperArch : kLowerArch;
  double arc = 0.0;
  std::vector<double> arc_at(kColumns);
  for (int c = kColumns / 2 + 1; c < kColumns; ++c) {
    const double u = (2.0 * c) / (kColumns - 1.0) - 1.0;
    const double before = (2.0 * c - 2.0) / (kColumns - 1.0) - 1.0;
    arc += (arch_at(u, arch) - arch_at(before, arch)).norm();
    arc_at[c] = arc;
    arc_at[kColumns - 1 - c] = arc;
  }
  for (int r = 0; r < kRows; ++r) {
    // 0 at the cutting edge, 1 in the gum.
    const double v = r < kOuter ? 1.0 - r / (kOuter - 1.0) : (r - kOuter + 0.6) / (kRows - kOuter);
    const double behind = r < kOuter ? 0.0 : 0.35 + 0.65 * std::sqrt(v);
    for (int c = 0; c < kColumns; ++c) {
      const double u = (2.0 * c) / (kColumns - 1.0) - 1.0;
      double start = 0.0;
      std::size_t tooth = 0;
      while (tooth + 1 < widths.size() && arc_at[c] > start + widths[tooth])
        start += widths[tooth++];
      const double across = std::clamp((arc_at[c] - start) / widths[tooth], 0.0, 1.0);
      const double middle = 4.0 * across * (1.0 - across);  // 0 between two teeth
      // Cutting teeth are thin, those that grind as thick as wide.
      const double thick = behind * (5.0 + 4.5 * smooth_step(0.25, 0.6, std::abs(u)));
      const Vec2 plan = arch_at(u, arch, 0.9 * std::pow(middle, 0.4) * (1 - v) - thick);
      const double height = (tooth == 1 && upper ? 0.8 : 0.0) + 0.6 * (1.0 - std::pow(middle, 0.3));
      const double up = arch.height_mm * v + (1.0 - v) * height;
      const double belly = r < kOuter ? 0.9 * std::pow(middle, 0.35) * smooth_step(0.85, 0.4, v) -
                                            2.2 * bump(v / 0.08)
                                      : -thick * std::cos(0.5 * M_PI * u);
      const double y = arch.edge_y_mm + (upper ? up : -up);
      part.mesh.positions_mm.push_back(
          shape.warp(Vec3(plan.x(), y, plan.y() + belly + (upper ? 0.0 : -0.4))));
      const double gum_line = (behind > 0.0 ? 0.42 : 0.66) + 0.12 * (1.0 - middle);
      Colour colour =
          mix(Colour(0.76F, 0.66F, 0.49F), Colour(0.88F, 0.80F, 0.65F), middle * (1.0 - v));
      colour = mix(Colour(0.16F, 0.10F, 0.08F), colour, 0.15 + std::pow(middle, 0.35));
      colour = mix(
          colour, Colour(0.42F, 0.13F, 0.12F), smooth_step(gum_line - 0.06, gum_line + 0.04, v));
      // The cheeks shade the back of the arch, and the mouth its inner face.
      if (behind > 0.0) colour *= 0.45F;
      part.albedo.push_back(colour * static_cast<float>(1.0 - 0.75 * std::abs(u) * std::abs(u)));
    }
  }
  join_grid(part, kRows, kColumns, false);
  if (!upper) {
    for (Triangle& t : part.mesh.triangles) std::swap(t[1], t[2]);
  }
  return part;
}

// An ellipsoid on the floor of the mouth.
RigidPart tongue(const HeadShape& shape) {
  constexpr int kRings = 20;
  constexpr int kAround = 28;
  const Vec3 centre(0.0, -82.5, -17.0);
  const Vec3 half_axes(17.5, 7.0, 21.0);
  RigidPart part;
  part.name = "tongue";
  part.bone = Bone::kMandible;
  part.gloss = 0.5F;
  for (int r = 0; r < kRings; ++r) {
    const double a = M_PI * (0.0005 + 0.999 * r / (kRings - 1.0));
    for (int k = 0; k < kAround; ++k) {
      const double b = 2.0 * M_PI * k / kAround;
      const Vec3 unit(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      part.mesh.positions_mm.push_back(shape.warp(centre + half_axes.cwiseProduct(unit)));
      part.albedo.push_back(
          mix(Colour(0.10F, 0.025F, 0.025F), Colour(0.40F, 0.13F, 0.12F), unit.z()));
    }
  }
  join_grid(part, kRings, kAround, true);
  return part;
}

// Height of the ear's relief over its plane, (p, q) = backwards and upwards from its middle, rho =
// 1 at the outline.
double ear_relief(double p, double q, double rho) {
  const double upper_back = smooth_step(-24.0, -6.0, q) * smooth_step(-15.0, -6.0, p + 0.25 * q);
  double h = 3.2 + 0.26 * (p + 13.0);                 // stands off at the back
  h += 3.4 * upper_back * bump((rho - 0.90) / 0.10);  // helix
  h -= 2.4 * upper_back * bump((rho - 0.72) / 0.09);  // scapha
  h += 2.6 * upper_back * bump((std::hypot(p + 2.0, 0.62 * q) / 11.5 - 0.80) / 0.20);  // antihelix
  h -= 4.4 * bump(std::hypot((p + 3.0) / 6.5, (q + 3.0) / 9.0));                       // concha
  h += 1.4 * bump(std::hypot((p + 3.0) / 8.0, (q + 24.0) / 7.0));                      // lobe
  // The front edge runs out into the cheek, but for the flap before the ear's opening.
  h -= 8.0 * smooth_step(0.55, 1.0, rho) * smooth_step(-2.0, -9.0, p);
  h += 6.5 * bump(std::hypot((p + 11.0) / 3.2, (q + 5.5) / 5.0));  // tragus
  return h - 3.0 * smooth_step(0.92, 1.0, rho);
}

RigidPart ear(const HeadShape& shape, const Identity& identity, bool left) {
  constexpr int kRings = 22;
  constexpr int kBehind = 3;  // rings that close the ear towards the head
  constexpr int kAround = 56;
  RigidPart part;
  part.name = left ? "ear_left" : "ear_right";
  const Vec3 middle = shape.position({Vec2(131.0, -17.0)}) + Vec3(-1.0, 0.0, 0.0);
  const Vec3 back(0.10, -0.17, -0.98);
  const Vec3 up(-0.04, 0.98, -0.18);
  const Vec3 out(0.98, 0.02, 0.10);
  const Colour skin = linear_from_srgb(identity.skin_tone);
  for (int r = 0; r < kRings + kBehind; ++r) {
    const double rho = std::min(1.0, (r + 0.02) / (kRings - 1.0));
    const double sink = std::max(0, r - kRings + 1) / static_cast<double>(kBehind);
    for (int k = 0; k < kAround; ++k) {
      const double a = 2.0 * M_PI * k / kAround;
      const double wide = std::cos(a) > 0.0 ? 16.5 : 13.0;
      const double p = rho * wide * std::cos(a) * (1.0 + 0.16 * std::sin(a)) * (1.0 - 0.10 * sink);
      const double q = rho * 29.0 * std::sin(a) * (1.0 - 0.06 * sink);
      const double h = ear_relief(p, q, rho) * (1.0 - sink) - 9.0 * sink;
      Vec3 at = middle + p * back + q * up + h * out;
      if (!left) at.x() = -at.x();
      part.mesh.positions_mm.push_back(at);
      const double pale = 0.12 * bump((rho - 0.88) / 0.1);
      part.albedo.push_back(skin.cwiseProduct(Colour(0.98F, 0.80F, 0.76F)) *
                            static_cast<float>(0.94 + pale));
    }
  }
  join_grid(part, kRings + kBehind, kAround, true);
  if (!left) {
    for (Triangle& t : part.mesh.triangles) std::swap(t[1], t[2]);
  }
  return part;
}

// A plain shirt: rings from the collar over the shoulders.
RigidPart shirt(const Identity& identity) {
  struct Ring {
    double half_width, half_depth, y, slope;  // slope: how much lower the front is than the back
  };
  constexpr std::array<Ring, 13> kRings{{{58.5, 43, -152, 10},
                                         {60, 44.5, -136, 10},
                                         {61.5, 46, -132, 10},
                                         {64, 48.5, -132.5, 10},
                                         {67, 51, -136, 10},
                                         {70, 53.5, -141.5, 11},
                                         {82, 60, -149, 12},
                                         {107, 71, -161, 13},
                                         {140, 82, -175, 12},
                                         {170, 92, -192, 10},
                                         {190, 99, -214, 8},
                                         {200, 106, -250, 4},
                                         {204, 110, -340, 0}}};
  constexpr int kAround = 72;
  // Cloth by seed: charcoal, navy, moss, wine, slate; linear.
  constexpr std::array<std::array<float, 3>, 5> kCloth{{{0.040F, 0.042F, 0.047F},
                                                        {0.022F, 0.034F, 0.075F},
                                                        {0.036F, 0.050F, 0.034F},
                                                        {0.085F, 0.020F, 0.026F},
                                                        {0.075F, 0.090F, 0.105F}}};
  const auto& cloth = kCloth[(identity.texture_seed + 4U) % kCloth.size()];
  RigidPart part;
  part.name = "shirt";
  part.gloss = 0.01F;
  for (std::size_t r = 0; r < kRings.size(); ++r) {
    const Ring& ring = kRings[r];
    for (int k = 0; k < kAround; ++k) {
      const double a = 2.0 * M_PI * k / kAround;
      const double x = std::sin(a);
      const double z = std::cos(a);
      // Shoulders are squarer than an ellipse.
      const double square =
          1.0 / std::pow(std::pow(std::abs(x), 2.4) + std::pow(std::abs(z), 2.4), 1.0 / 2.4);
      part.mesh.positions_mm.emplace_back(identity.face_width * ring.half_width * x * square,
                                          identity.face_height * ring.y - ring.slope * z,
                                          -90.0 + ring.half_depth * z * square);
      const float rib = r >= 1 && r <= 5 ? 0.88F : 1.0F;
      part.albedo.push_back(rib * Colour(cloth[0], cloth[1], cloth[2]));
    }
  }
  join_grid(part, static_cast<int>(kRings.size()), kAround, true);
  return part;
}

// What the chart continues to behind the outline of the skin: the back of the skull with its hair,
// and the nape. It emerges from the skin a little in front of the outline, so that the two surfaces
// meet without a gap or a step in their normals.
RigidPart back_of_head(const HeadShape& shape, const Identity& identity) {
  constexpr int kRows = 30;      // from the outline to the middle of the back
  constexpr int kColumns = 361;  // around the outline, from the subject's right over the crown
  constexpr int kInside = 2;     // rows in front of the outline
  constexpr double kSunk = 0.5;
  // Distance from the spine in the middle of the back.
  static const FunctionCurve middle({{-175, 62},
                                     {-150, 63},
                                     {-120, 65},
                                     {-95, 68},
                                     {-70, 77},
                                     {-45, 87},
                                     {-20, 94},
                                     {20, 98},
                                     {21, 98}});
  RigidPart part;
  part.name = "back_of_head";
  for (int r = 0; r < kRows; ++r) {
    const double t = (r - kInside) / (kRows - 1.0 - kInside);
    const double out = smooth_step(0.0, 1.0, t);
    for (int c = 0; c < kColumns; ++c) {
      const double u = 2.0 * c / (kColumns - 1.0) - 1.0;  // 0 at the crown
      Vec2 edge = outline_point(std::abs(u));
      if (r < kInside) edge -= (3.0 * (kInside - r)) * Vec2(edge.x(), edge.y() - 20.0) / 180.0;
      const Ray ray = chart_ray(edge);
      const double from = std::atan2(ray.direction.head<2>().norm(), ray.direction.z());
      const double angle = from + (M_PI - from) * std::max(0.0, t);
      const Vec2 aside = ray.direction.head<2>().normalized();
      const double y = std::min(edge.y(), 20.0);
      const double bare = shape.section(edge) + (middle(y) - shape.section(edge)) * out;
      const double thick =
          shape.hair_mm(edge) * (1.0 - out) + 8.0 * smooth_step(-82.0, -50.0, y) * out;
      const Vec3 direction(
          std::sin(angle) * aside.x(), std::sin(angle) * aside.y(), std::cos(angle));
      const double sunk = r == 0 ? kSunk : -0.2 * kSunk;
      Vec3 at = shape.warp(ray.origin_mm + (bare + thick - sunk) * direction);
      if (u < 0.0) at.x() = -at.x();
      part.mesh.positions_mm.push_back(at);
      const double elevation = edge.y() - ray.origin_mm.y();
      const double go_on = angle / from;
      const Vec2 domain(edge.x() * go_on, ray.origin_mm.y() + elevation * go_on);
      part.albedo.push_back(linear_from_srgb(hair_over_skin(
          identity, {u < 0.0 ? -domain.x() : domain.x(), domain.y()}, thick, identity.skin_tone)));
    }
  }
  join_grid(part, kRows, kColumns, false);
  for (Triangle& t : part.mesh.triangles) std::swap(t[1], t[2]);
  return part;
}

// The pink flesh in the inner corner of the eye; side = +1: the left one.
RigidPart caruncle(const HeadShape& shape, double side) {
  const Vec3 corner = shape.eye_centre() + Vec3(-12.4, -3.5, 7.6);
  RigidPart flesh;
  constexpr int kRings = 9;
  constexpr int kAround = 14;
  for (int r = 0; r < kRings; ++r) {
    const double a = M_PI * (0.0005 + 0.999 * r / (kRings - 1.0));
    for (int k = 0; k < kAround; ++k) {
      const double b = 2.0 * M_PI * k / kAround;
      flesh.mesh.positions_mm.emplace_back(
          3.6 * std::sin(a) * std::cos(b), 2.6 * std::sin(a) * std::sin(b), 3.7 * std::cos(a));
      flesh.albedo.emplace_back(0.50F, 0.25F, 0.22F);
    }
  }
  join_grid(flesh, kRings, kAround, true);
  for (Vec3& at : flesh.mesh.positions_mm) {
    at += corner;
    at.x() *= side;
  }
  if (side < 0.0) {
    for (Triangle& t : flesh.mesh.triangles) std::swap(t[1], t[2]);
  }
  flesh.name = side > 0.0 ? "caruncle_left" : "caruncle_right";
  flesh.gloss = 0.4F;
  return flesh;
}

}  // namespace

Teeth make_teeth(const HeadShape& shape) {
  const auto warped = [&](const DentalArch& arch, double towards_gum) {
    const double back_z = arch.front_z_mm - arch.depth_mm;
    const Vec3 front = shape.warp(Vec3(0.0, arch.edge_y_mm, arch.front_z_mm));
    const Vec3 side = shape.warp(Vec3(arch.half_width_mm, arch.edge_y_mm, back_z));
    const Vec3 gum =
        shape.warp(Vec3(0.0, arch.edge_y_mm + towards_gum * arch.height_mm, arch.front_z_mm));
    return DentalArch{
        side.x(), front.z() - side.z(), front.z(), front.y(), towards_gum * (gum.y() - front.y())};
  };
  return {warped(kUpperArch, +1.0), warped(kLowerArch, -1.0)};
}

std::vector<RigidPart> make_rigid_parts(const HeadShape& shape, const Identity& identity) {
  std::vector<RigidPart> parts{
      eyeball(shape, true), eyeball(shape, false), teeth(shape, true), teeth(shape, false)};
  parts.push_back(tongue(shape));
  parts.push_back(ear(shape, identity, true));
  parts.push_back(ear(shape, identity, false));
  parts.push_back(shirt(identity));
  parts.push_back(caruncle(shape, +1.0));
  parts.push_back(caruncle(shape, -1.0));
  parts.push_back(back_of_head(shape, identity));
  return parts;
}

}  // namespace zygoma
