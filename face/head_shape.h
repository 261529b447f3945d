// The shape of the default head: measured sections (head_sections.h) on the chart (head_chart.h),
// plus what sections cannot hold: lids that follow the eyeball, the lid crease, the slit of the
// mouth with lips that roll inwards, nostrils, the thickness of the hair; and the identity's warp.
//
// Features are authored in the frontal picture of the default head (x, y in mm, landmarks of the
// face frame) and mapped to the domain once.
#pragma once

#include <vector>

#include "face/generic_head.h"
#include "face/head_chart.h"

namespace zygoma {

enum class Rim : std::uint8_t { kNone, kMouth, kEye };

// A point of the surface before it has a place in space. Points of a rim lie on its opening;
// `inward` > 0 continues behind it (inner lip, lid margin).
struct DomainPoint {
  Vec2 at_mm{0.0, 0.0};
  Rim rim = Rim::kNone;
  int side = 0;         // of the rim: +1 upper, -1 lower, 0 corner
  double inward = 0.0;  // [0, 1]
};

// Smooth curve y(x) through points of increasing x.
class FunctionCurve {
 public:
  explicit FunctionCurve(std::vector<Vec2> points);
  double operator()(double x) const;
  double first_x() const { return points_.front().x(); }
  double last_x() const { return points_.back().x(); }

 private:
  std::vector<Vec2> points_;
  std::vector<double> slope_;
};

struct EyeShape {
  Vec3 centre_mm{31.5, 0.0, -16.3};  // of the left eyeball; the right one is its mirror image
  double radius_mm = 14.5;
  double iris_radius_mm = 6.0;
};

class HeadShape {
 public:
  explicit HeadShape(const Identity& identity);

  Vec3 position(const DomainPoint& point) const;
  // Where the left eyeball's centre is for this identity.
  Vec3 eye_centre() const;
  // Warp of the identity for parts that are authored in space (teeth).
  Vec3 warp(const Vec3& p) const;

  // Domain of a point of the default head's frontal picture, x >= 0, |x| < 65 mm.
  Vec2 domain_from_front(const Vec2& front_mm) const;
  // Frontal picture of a domain point on the default head, x as its magnitude.
  Vec2 front_from_domain(const Vec2& domain_mm) const;

  // Openings in the domain, X >= 0: y at X for the upper (+1) or lower (-1) rim.
  double mouth_rim(double x, int side) const {
    return side > 0 ? mouth_upper_(x) : mouth_lower_(x);
  }
  double eye_rim(double x, int side) const { return side > 0 ? eye_upper_(x) : eye_lower_(x); }
  double mouth_corner_x() const { return mouth_upper_.last_x(); }
  double eye_inner_x() const { return eye_upper_.first_x(); }
  double eye_outer_x() const { return eye_upper_.last_x(); }
  const EyeShape& eye() const { return eye_; }

  // Distance from the spine without hair and what sections cannot hold.
  double section(const Vec2& domain_mm) const { return sections_(domain_mm); }

  // Thickness of the hair, millimetres; 0 on the face.
  double hair_mm(const Vec2& domain_mm) const;
  // Border of the hair on the forehead, domain Y at |X|; the temple's is vertical below.
  double hairline(double x) const { return hairline_(x); }

 private:
  Vec3 outer(const Vec2& domain_mm) const;
  Vec3 default_position(const DomainPoint& point) const;
  Vec3 base(const Vec2& domain_mm) const;
  double lip_relief(const Vec2& front_mm) const;
  double lid_relief(const Vec2& front_mm) const;
  double wing_relief(const Vec2& front_mm) const;

  Identity identity_;
  EyeShape eye_;
  DepthSpline sections_;
  FunctionCurve mouth_upper_;
  FunctionCurve mouth_lower_;
  FunctionCurve eye_upper_;
  FunctionCurve eye_lower_;
  FunctionCurve hairline_;
};

// Authored curves of the default head in the frontal picture, x >= 0, from the middle outwards.
const std::vector<Vec2>& upper_lip_border();
const std::vector<Vec2>& lower_lip_border();
const std::vector<Vec2>& mouth_line();
const std::vector<Vec2>& brow_upper_edge();
const std::vector<Vec2>& brow_lower_edge();
const std::vector<Vec2>& furrow_line();
const std::vector<Vec2>& nose_base_line();
const std::vector<Vec2>& chin_border();
// Lid margins of the left eye at s in [0, 1] from the inner to the outer corner.
Vec2 lid_margin(double s, int side);

double bump(double t);  // exp(-t^2)

}  // namespace zygoma
