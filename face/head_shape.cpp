#include "face/head_shape.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "face/head_sections.h"

namespace zygoma {
namespace {

// Half the gap of the closed mouth in the domain: keeps the two lips apart in the flat mesh.
constexpr double kSlitHalfGap = 0.10;

DepthSpline measured_sections() {
  std::vector<double> coefficients;
  for (const auto& row : kSectionDistance) {
    coefficients.insert(coefficients.end(), std::begin(row), std::end(row));
  }
  return DepthSpline({std::begin(kSectionX), std::end(kSectionX)},
                     {std::begin(kSectionY), std::end(kSectionY)},
                     std::move(coefficients));
}

Vec3 along(const Ray& ray, double distance) { return ray.origin_mm + distance * ray.direction; }

Vec2 chart_of(const DepthSpline& sections, const Vec2& front) {
  Vec2 domain = front;
  for (int i = 0; i < 60; ++i) {
    const Vec3 p = along(chart_ray(domain), sections(domain));
    domain += 0.7 * (front - p.head<2>());
    domain.x() = std::max(0.0, domain.x());
  }
  return domain;
}

FunctionCurve mapped(const DepthSpline& sections, const std::vector<Vec2>& front, double shift) {
  std::vector<Vec2> points;
  const double last = front.back().x();
  for (const Vec2& p : front) {
    const double open = std::sqrt(std::max(0.0, 1.0 - p.x() / last));
    points.push_back(chart_of(sections, p) + Vec2(0.0, shift * std::min(1.0, 2.0 * open)));
  }
  points.front().x() = 0.0;
  return FunctionCurve(std::move(points));
}

FunctionCurve lid(const DepthSpline& sections, int side) {
  std::vector<Vec2> points;
  for (int i = 0; i <= 24; ++i) {
    // Denser at the corners, where the margin turns.
    const double s = 0.5 - 0.5 * std::cos(M_PI * i / 24.0);
    points.push_back(chart_of(sections, lid_margin(s, side)));
  }
  return FunctionCurve(std::move(points));
}

}  // namespace

double bump(double t) { return std::exp(-t * t); }

FunctionCurve::FunctionCurve(std::vector<Vec2> points) : points_(std::move(points)) {
  const std::size_t n = points_.size();
  slope_.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2& a = points_[i > 0 ? i - 1 : i];
    const Vec2& b = points_[i + 1 < n ? i + 1 : i];
    slope_[i] = (b.y() - a.y()) / (b.x() - a.x());
  }
  if (points_.front().x() == 0.0) slope_.front() = 0.0;  // even in x
}

double FunctionCurve::operator()(double x) const {
  x = std::clamp(x, first_x(), last_x());
  std::size_t i = 0;
  while (i + 2 < points_.size() && x > points_[i + 1].x()) ++i;
  const double h = points_[i + 1].x() - points_[i].x();
  const double t = (x - points_[i].x()) / h;
  const double t2 = t * t;
  const double t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * points_[i].y() + (t3 - 2 * t2 + t) * h * slope_[i] +
         (3 * t2 - 2 * t3) * points_[i + 1].y() + (t3 - t2) * h * slope_[i + 1];
}

const std::vector<Vec2>& mouth_line() {
  static const std::vector<Vec2> line{
      {0, -69.0}, {5, -68.7}, {10, -68.5}, {15, -68.8}, {20, -69.5}, {25.4, -70.4}};
  return line;
}
const std::vector<Vec2>& upper_lip_border() {
  static const std::vector<Vec2> line{{0, -61.2},
                                      {3, -60.5},
                                      {6, -59.8},
                                      {9, -60.3},
                                      {13, -61.8},
                                      {17, -63.7},
                                      {21, -66.4},
                                      {25.4, -70.4}};
  return line;
}
const std::vector<Vec2>& lower_lip_border() {
  static const std::vector<Vec2> line{
      {0, -78.6}, {5, -78.5}, {10, -77.8}, {15, -76.3}, {20, -73.9}, {23, -72.1}, {25.4, -70.4}};
  return line;
}
const std::vector<Vec2>& brow_upper_edge() {
  static const std::vector<Vec2> line{
      {10.5, 20.0}, {16, 23.0}, {24, 25.6}, {33, 27.4}, {40, 27.4}, {47, 25.0}, {54.5, 19.5}};
  return line;
}
const std::vector<Vec2>& brow_lower_edge() {
  static const std::vector<Vec2> line{
      {10.5, 13.2}, {16, 14.8}, {24, 17.2}, {33, 20.0}, {40, 21.4}, {47, 20.8}, {54.5, 18.6}};
  return line;
}
const std::vector<Vec2>& furrow_line() {
  static const std::vector<Vec2> line{
      {17.5, -39.5}, {20.5, -44.5}, {24, -50}, {27.5, -56}, {30.5, -62.5}, {32.5, -70}};
  return line;
}
const std::vector<Vec2>& nose_base_line() {
  static const std::vector<Vec2> line{{0, -47.2}, {4, -46.2}, {8, -46.6}, {12, -47.0}, {16, -44.0}};
  return line;
}
const std::vector<Vec2>& chin_border() {
  static const std::vector<Vec2> line{{0, -109.6}, {5, -109.2}, {10, -108.2}, {15, -106.4}};
  return line;
}

Vec2 lid_margin(double s, int side) {
  s = std::clamp(s, 0.0, 1.0);
  const Vec2 inner(17.4, -3.4);
  const Vec2 outer(44.6, -1.2);
  const Vec2 chord = inner + s * (outer - inner);
  // Each margin is a beta-shaped arch over the line of the corners.
  const double a = side > 0 ? 0.62 : 0.85;
  const double b = side > 0 ? 0.74 : 0.70;
  const double peak = std::pow(a / (a + b), a) * std::pow(b / (a + b), b);
  const double arch = std::pow(s, a) * std::pow(1.0 - s, b) / peak;
  return chord + Vec2(0.0, side > 0 ? 7.3 * arch : -3.6 * arch);
}

HeadShape::HeadShape(const Identity& identity)
    : identity_(identity),
      sections_(measured_sections()),
      mouth_upper_(mapped(sections_, mouth_line(), kSlitHalfGap)),
      mouth_lower_(mapped(sections_, mouth_line(), -kSlitHalfGap)),
      eye_upper_(lid(sections_, +1)),
      eye_lower_(lid(sections_, -1)),
      hairline_({{0, 74},
                 {16, 75},
                 {32, 76.5},
                 {46, 73},
                 {57, 64},
                 {67, 51},
                 {77, 38},
                 {88, 24},
                 {97, 8},
                 {104, 2},
                 {111, 2},
                 {118, 5},
                 {126, 9},
                 {140, 11},
                 {154, 5},
                 {166, -20},
                 {178, -60}}) {}

Vec3 HeadShape::base(const Vec2& domain_mm) const {
  return along(chart_ray(domain_mm), sections_(domain_mm));
}

Vec2 HeadShape::domain_from_front(const Vec2& front_mm) const {
  return chart_of(sections_, front_mm);
}

Vec2 HeadShape::front_from_domain(const Vec2& domain_mm) const {
  return base(Vec2(std::abs(domain_mm.x()), domain_mm.y())).head<2>();
}

double HeadShape::hair_mm(const Vec2& domain_mm) const {
  const double x = std::abs(domain_mm.x());
  const double slope = 0.25 * (hairline_(x + 2.0) - hairline_(x - 2.0));
  const double inside = (domain_mm.y() - hairline_(x)) / std::sqrt(1.0 + slope * slope);
  const double full =
      10.0 - 5.0 * smooth_step(60.0, 105.0, x) * smooth_step(70.0, 30.0, domain_mm.y());
  return full * smooth_step(-1.0, 24.0, inside);
}

double HeadShape::lip_relief(const Vec2& front) const {
  const double x = front.x();
  if (x > 40.0 || front.y() < -95.0 || front.y() > -45.0) return 0.0;
  static const FunctionCurve line(mouth_line());
  static const FunctionCurve upper(upper_lip_border());
  static const FunctionCurve lower(lower_lip_border());
  const double d = front.y() - line(x);
  const double middle = std::sqrt(std::max(0.0, 1.0 - std::pow(x / 26.0, 2.0)));
  // The lips roll in towards the slit; the corner is a small pit.
  double relief = -(0.8 + 2.0 * middle) * std::exp(-std::abs(d) / 1.7) * smooth_step(30.0, 22.0, x);
  relief -= 1.0 * bump(std::hypot(x - 26.0, d) / 3.0);
  if (x < 25.4) {
    // Volume of the red, and the white roll along its border.
    const double to_upper = front.y() - upper(x);
    const double to_lower = front.y() - lower(x);
    relief += middle * (0.45 * bump(to_upper / 1.1) - 0.5 * bump((to_upper - 2.6) / 2.0));
    relief += middle * (0.9 * bump((to_lower - 4.2) / 2.8) - 0.5 * bump((to_lower + 2.5) / 2.6));
  }
  // Philtrum: a groove between two ridges.
  const double philtrum =
      smooth_step(-61.0, -58.5, front.y()) * smooth_step(-48.0, -51.0, front.y());
  relief += philtrum * (0.45 * bump((x - 5.0) / 1.8) - 0.7 * bump(x / 2.6));
  return relief;
}

double HeadShape::lid_relief(const Vec2& front) const {
  const double s = (front.x() - 17.4) / (44.6 - 17.4);
  if (s < -0.1 || s > 1.25 || std::abs(front.y()) > 22.0) return 0.0;
  const double window = smooth_step(-0.02, 0.3, s) * smooth_step(1.12, 0.7, s);
  const double t = std::clamp(s, 0.0, 1.0);
  const double above = front.y() - lid_margin(t, +1).y();
  const double below = lid_margin(t, -1).y() - front.y();
  double relief = window * (-1.5 * bump((above - 5.6) / 1.25) + 0.9 * bump((above - 8.6) / 2.2));
  // The lower lid's plate and the faint groove under it.
  relief += window * (0.35 * bump((below - 1.8) / 1.6) - 0.5 * bump((below - 6.5) / 2.4));
  return relief;
}

double HeadShape::wing_relief(const Vec2& front) const {
  // The wing is a shell over the nostril, set off by a groove that runs around it.
  const Vec2 off = front - Vec2(11.2, -40.2);
  const double around = std::hypot(off.x() / 6.1, off.y() / 6.9);
  const double angle = std::atan2(off.y(), off.x());
  // Open towards the tip of the nose: full from the upper side over the back to the lower side.
  const double back = smooth_step(2.5, 1.4, std::abs(angle - 0.35));
  return back * (0.7 * bump((around - 0.62) / 0.34) - 1.5 * bump((around - 1.08) / 0.17));
}

Vec3 HeadShape::outer(const Vec2& domain) const {
  const Ray ray = chart_ray(domain);
  double distance = sections_(domain);
  const Vec3 plain = along(ray, distance);
  if (domain.x() < 70.0 && domain.y() > -120.0 && domain.y() < 45.0) {
    const Vec2 front = plain.head<2>();
    distance += lip_relief(front) + lid_relief(front);
    // Nostrils: hollows in the underside of the nose.
    const Vec2 to_nostril = front - Vec2(6.6, -45.4);
    distance -= 5.0 * bump(std::hypot(to_nostril.x() / 3.4, to_nostril.y() / 2.0));
    distance += wing_relief(front);
  }
  Vec3 p = along(ray, distance + hair_mm(domain));
  // Lids and their surroundings never dip below the eyeball: smooth maximum with a sphere.
  const Vec2 off = p.head<2>() - eye_.centre_mm.head<2>();
  const double reach = eye_.radius_mm + 0.9;
  if (off.squaredNorm() < reach * reach) {
    const double sphere = eye_.centre_mm.z() + std::sqrt(reach * reach - off.squaredNorm());
    constexpr double kSoft = 0.5;
    const double d = (sphere - p.z()) / kSoft;
    p.z() += kSoft * (d > 30.0 ? d : std::log1p(std::exp(d)));
  }
  return p;
}

Vec3 HeadShape::default_position(const DomainPoint& point) const {
  Vec3 p = outer(point.at_mm);
  if (point.inward <= 0.0) return p;
  const double t = point.inward;
  if (point.rim == Rim::kEye) {
    return p + 3.2 * t * (eye_.centre_mm - p).normalized();
  }
  // The inner lip turns away from the slit and hugs the teeth.
  const double curl = point.side * (2.8 * t * t - 0.5 * std::sin(M_PI * std::min(1.0, 1.6 * t)));
  return p + Vec3(-0.04 * t * p.x(), curl, -4.5 * std::sin(0.5 * M_PI * t));
}

Vec3 HeadShape::warp(const Vec3& p) const {
  const double x = std::abs(p.x());
  const double sign = p.x() < 0.0 ? -1.0 : 1.0;
  const Identity& id = identity_;
  Vec3 q(x, p.y(), p.z());
  const double nose =
      bump(x / 17.0) * smooth_step(-60.0, -47.0, p.y()) * smooth_step(6.0, -8.0, p.y());
  q.y() += (id.nose_length - 1.0) * nose * p.y();
  q.z() += (id.nose_length - 1.0) * nose * 0.8 * std::max(0.0, p.z() - 8.0);
  const double wings = bump(std::max(0.0, x - 10.0) / 10.0) * bump((p.y() + 38.0) / 16.0);
  q.x() += (id.nose_width - 1.0) * wings * x;
  static const FunctionCurve line(mouth_line());
  const double off = p.y() - line(x);
  const double lip = bump(std::max(0.0, std::abs(off) - 7.0) / 6.0) * smooth_step(27.0, 14.0, x);
  q.y() += (id.lip_fullness - 1.0) * 0.75 * lip * off;
  q.z() += (id.lip_fullness - 1.0) * 3.0 * lip * bump((std::abs(off) - 4.0) / 4.5);
  q.y() += id.brow_height_mm * bump((p.y() - 24.0) / 13.0) * smooth_step(75.0, 55.0, x);
  q.y() +=
      (id.chin_length - 1.0) * std::min(0.0, p.y() + 80.0) * smooth_step(-160.0, -125.0, p.y());
  const double jaw = smooth_step(-45.0, -95.0, p.y()) * smooth_step(-170.0, -135.0, p.y());
  q.x() *= id.face_width * (1.0 + (id.jaw_width - 1.0) * jaw);
  q.y() *= id.face_height;
  const double eye = smooth_step(34.0, 16.0, std::hypot(x - eye_.centre_mm.x(), p.y()));
  q.x() += (id.eye_distance - 1.0) * eye_.centre_mm.x() * eye;
  q.x() *= sign;
  return q;
}

Vec3 HeadShape::eye_centre() const { return warp(eye_.centre_mm); }

Vec3 HeadShape::position(const DomainPoint& point) const {
  DomainPoint left = point;
  const double sign = point.at_mm.x() < 0.0 ? -1.0 : 1.0;
  left.at_mm.x() = std::abs(point.at_mm.x());
  const Vec3 p = default_position(left);
  Vec3 q = warp(p);
  // The lids move with the eyeball as one piece.
  const double rigid = smooth_step(26.0, 15.5, (p.head<2>() - eye_.centre_mm.head<2>()).norm());
  q += rigid * (p + eye_centre() - eye_.centre_mm - q);
  if (point.at_mm.x() == 0.0) q.x() = 0.0;
  q.x() *= sign;
  return q;
}

}  // namespace zygoma
