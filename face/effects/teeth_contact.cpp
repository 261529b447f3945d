// Teeth contact: lips lie on the teeth and do not enter them (paper, the f_i of equation (2):
// "collision between lips and teeth").
//
//   E = sum_v A S/3 W(y) max(0, d - D(x_v))^3
//
// over the vertices of the lips and both rows of teeth. D is the distance from the dental arch,
// positive in front of it; W fades in from the cutting edge towards the gum, so that a lip may be
// tucked behind the teeth. The lower row goes with the jaw. d is the clearance, or what rest leaves
// of it (also where the authored lip lies inside the arch), so that the face at rest is free of
// force; S is the pressure 1 mm beyond it, on the area A of the vertex. All is C2. External: teeth
// are no nodes. A face without teeth has no such term.
#include <algorithm>
#include <cmath>

#include "face/effect.h"
#include "face/jaw.h"

namespace zygoma {
namespace {

double cube(double t) { return t * t * t; }

// A value that depends on a place, with its derivatives.
struct Field {
  double value = 0.0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

// Distance from the arch, exact to first order at its front and sides: there 1 - sqrt(the left side
// of its equation) falls off alike.
Field distance_from(const DentalArch& arch, const Vec3& q) {
  constexpr double kSoftening = 1e-4;  // keeps the middle of the mouth smooth
  const double scale_mm = 0.5 * (arch.half_width_mm + arch.depth_mm / 1.25);
  const double w2 = arch.half_width_mm * arch.half_width_mm;
  const double t = std::max(0.0, (q.z() - arch.front_z_mm) / arch.depth_mm + 1.0);
  const double root_t = std::sqrt(t);
  const double inside = q.x() * q.x() / w2 + t * t * root_t;
  const Vec3 slope(2.0 * q.x() / w2, 0.0, 2.5 * t * root_t / arch.depth_mm);
  const double root = std::sqrt(inside + kSoftening);
  Field d;
  d.value = scale_mm * (root - std::sqrt(1.0 + kSoftening));
  d.first = (scale_mm / (2.0 * root)) * slope;
  d.second = (-scale_mm / (4.0 * cube(root))) * slope * slope.transpose();
  d.second(0, 0) += scale_mm / root / w2;
  d.second(2, 2) += scale_mm / (2.0 * root) * 3.75 * root_t / (arch.depth_mm * arch.depth_mm);
  return d;
}

class TeethContact final : public EnergyTerm {
 public:
  TeethContact(const EffectValues& values, const Anatomy& anatomy)
      : jaw_(anatomy.jaw), teeth_(*anatomy.teeth) {
    const std::vector<double> area = vertex_areas(anatomy.surface);
    for (std::size_t v = 0; v < area.size(); ++v) {
      const Region region = anatomy.region[v];
      if (region != Region::kUpperLip && region != Region::kLowerLip) continue;
      const auto gap = [&](const DentalArch& arch) {
        const double at_rest = distance_from(arch, anatomy.surface.positions_mm[v]).value;
        return std::min(at_rest, values["clearance_mm"]);
      };
      sites_.push_back({static_cast<int>(v),
                        values["stiffness_kpa"] / 3.0 * area[v],
                        {gap(teeth_.upper), gap(teeth_.lower)}});
    }
    moving_ = sites_;
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    double energy = 0.0;
    for (const Site& site : moving_) {
      const Field lower = lower_teeth(site, x[site.vertex]);
      const Field upper = penalty(site, 0, x[site.vertex]);
      energy += upper.value + lower.value;
      gradient.segment<3>(3 * site.vertex) += upper.first + lower.first;
    }
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const override {
    for (const Site& site : sites_) {
      const Field lower = lower_teeth(site, x[site.vertex]);
      const Field upper = penalty(site, 0, x[site.vertex]);
      sink.add(site.vertex, site.vertex, upper.second + lower.second);
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    moving_.clear();
    for (const Site& site : sites_) {
      if (moving[site.vertex]) moving_.push_back(site);
    }
  }

  void follow_jaw(double jaw_rad) override {
    jaw_rad_ = jaw_rad;
    open_ = open_from_closed(jaw_, jaw_rad);
    closed_ = open_.inverse();
  }

  void add_jaw_force(const std::vector<Vec3>& x,
                     Eigen::Ref<Eigen::VectorXd> forces) const override {
    for (const Site& site : sites_) {
      const Field lower = lower_teeth(site, x[site.vertex]);
      // The teeth turn under the lip: the force turns with them, and the lip moves against them.
      const Vec3 rate = opening_rate(jaw_, jaw_rad_, closed_ * x[site.vertex]);
      forces.segment<3>(3 * site.vertex) += lower.second * rate - Vec3::UnitX().cross(lower.first);
    }
  }

 private:
  struct Site {
    int vertex = 0;
    double scale = 0.0;              // A S/3
    std::array<double, 2> gap_mm{};  // d from the upper and the lower arch
  };

  Field penalty(const Site& site, int row, const Vec3& q) const {
    constexpr double kFadeMm = 2.0;
    const DentalArch& arch = row == 0 ? teeth_.upper : teeth_.lower;
    const double up = row == 0 ? 1.0 : -1.0;  // from the cutting edge to the gum
    const double t = std::min(1.0, up * (q.y() - arch.edge_y_mm) / kFadeMm);
    if (t <= 0.0) return {};
    const Field d = distance_from(arch, q);
    const double depth = site.gap_mm[row] - d.value;
    if (depth <= 0.0) return {};
    const double w = cube(t) * (10.0 - 15.0 * t + 6.0 * t * t);
    const double w1 = up / kFadeMm * 30.0 * t * t * (1.0 - t) * (1.0 - t);
    const double w2 = 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / (kFadeMm * kFadeMm);
    Field e;
    e.value = site.scale * w * cube(depth);
    e.first = (-3.0 * site.scale * w * depth * depth) * d.first;
    e.second = (6.0 * site.scale * w * depth) * d.first * d.first.transpose() -
               (3.0 * site.scale * w * depth * depth) * d.second;
    const Vec3 turn = (-3.0 * site.scale * w1 * depth * depth) * d.first;
    e.second.row(1) += turn.transpose();
    e.second.col(1) += turn;
    e.second(1, 1) += site.scale * w2 * cube(depth);
    e.first.y() += site.scale * w1 * cube(depth);
    return e;
  }

  // In the frame of the skull.
  Field lower_teeth(const Site& site, const Vec3& x) const {
    const Field e = penalty(site, 1, closed_ * x);
    return {
        e.value, open_.linear() * e.first, open_.linear() * e.second * open_.linear().transpose()};
  }

  const Jaw& jaw_;
  const Teeth& teeth_;
  double jaw_rad_ = 0.0;
  Eigen::Isometry3d open_ = Eigen::Isometry3d::Identity();  // lower teeth from where they rest
  Eigen::Isometry3d closed_ = Eigen::Isometry3d::Identity();
  std::vector<Site> sites_;
  std::vector<Site> moving_;  // those whose vertex moves
};

}  // namespace

Effect make_teeth_contact_effect() {
  Effect effect;
  effect.name = "teeth_contact";
  effect.what = "lips stop at the teeth; for mouths that press, or are drawn over the teeth";
  effect.parameters = {
      {"clearance_mm",
       0.3,
       0.0,
       3.0,
       "where contact begins; at 0 lips sink into the teeth, above 2 the arch acts too wide"},
      {"stiffness_kpa",
       2000.0,
       1.0,
       1e6,
       "pressure 1 mm beyond; below 200 lips sink into the teeth, above 1e5 steps of the solvers "
       "become short"},
  };
  effect.called_for_when = "lips are drawn onto the teeth";
  effect.internal = false;
  effect.build = [](const EffectValues& values,
                    const Anatomy& anatomy,
                    const Lattice& /*lattice*/,
                    Effects& effects) {
    if (anatomy.teeth) effects.file(std::make_shared<TeethContact>(values, anatomy));
  };
  return effect;
}

}  // namespace zygoma
