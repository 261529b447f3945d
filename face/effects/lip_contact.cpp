// Lip contact: the lips do not pass through each other (paper, the f_i of equation (2)).
//
//   E = sum_(u, l) A_u A_l / (pi/4 R_x R_z) S/3 w max(0, d - s)^3
//   w = max(0, 1 - (x / R_x)^2 - (z / R_z)^2)^3
//
// over pairs of vertices of the upper and the lower lip that can meet, chosen once. s is the height
// of u over l and (x, z) how far they are beside each other: up is the direction in which a mouth
// closes. Lips are thick, so R_z is long; the corners of a smiling mouth rise beside its middle, so
// R_x is short. d is the clearance, or the gap that rest leaves, so that the face at rest is free
// of force; S is the pressure 1 mm beyond it and A the area of a vertex, which makes the sum an
// integral that hardly depends on the mesh. All is C2. External in that up is the head's.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "face/effect.h"

namespace zygoma {
namespace {

double cube(double t) { return t * t * t; }

class LipContact final : public EnergyTerm {
 public:
  LipContact(const EffectValues& values, const Anatomy& anatomy, const Lattice& lattice) {
    const std::vector<double> area = vertex_areas(anatomy.surface);
    const std::vector<Vec3>& rest = lattice.rest_mm;
    const double r_x = values["reach_along_mm"];
    const double r_z = values["reach_across_mm"];
    near_per_mm2_ = Vec3(1.0 / (r_x * r_x), 0.0, 1.0 / (r_z * r_z));
    const double weights_mm2 = 0.25 * std::numbers::pi * r_x * r_z;  // integral of w
    // Farther apart at rest than this, in reaches beside each other and in mm of height, no pair
    // will meet.
    constexpr double kFarBeside = 1.5;
    constexpr double kFarAboveMm = 15.0;
    for (int u = 0; u < lattice.num_vertices; ++u) {
      for (int l = 0; l < lattice.num_vertices; ++l) {
        if (anatomy.region[u] != Region::kUpperLip) continue;
        if (anatomy.region[l] != Region::kLowerLip) continue;
        const Vec3 r = rest[u] - rest[l];
        const bool joined =
            std::binary_search(lattice.neighbors[u].begin(), lattice.neighbors[u].end(), l);
        const double beside = std::sqrt(r.dot(near_per_mm2_.cwiseProduct(r)));
        if (joined || beside > kFarBeside || std::abs(r.y()) > kFarAboveMm) continue;
        pairs_.push_back({u,
                          l,
                          std::min(r.y(), values["clearance_mm"]),
                          values["stiffness_kpa"] / 3.0 * area[u] * area[l] / weights_mm2});
      }
    }
    moving_ = pairs_;
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    double energy = 0.0;
    for (const Pair& pair : moving_) {
      const Vec3 r = x[pair.upper] - x[pair.lower];
      const Vec3 beside = near_per_mm2_.cwiseProduct(r);
      const double near = 1.0 - beside.dot(r);
      const double depth = pair.gap_mm - r.y();
      if (depth <= 0.0 || near <= 0.0) continue;
      energy += pair.scale * cube(near) * cube(depth);
      Vec3 g = (-6.0 * pair.scale * near * near * cube(depth)) * beside;
      g.y() -= 3.0 * pair.scale * cube(near) * depth * depth;
      gradient.segment<3>(3 * pair.upper) += g;
      gradient.segment<3>(3 * pair.lower) -= g;
    }
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const override {
    for (const Pair& pair : pairs_) {
      const Vec3 r = x[pair.upper] - x[pair.lower];
      const Vec3 beside = near_per_mm2_.cwiseProduct(r);
      const double near = std::max(0.0, 1.0 - beside.dot(r));
      const double depth = std::max(0.0, pair.gap_mm - r.y());
      const double turn = 18.0 * near * near * depth * depth;
      Eigen::Matrix3d piece = (24.0 * near * cube(depth)) * beside * beside.transpose();
      piece.diagonal() -= (6.0 * near * near * cube(depth)) * near_per_mm2_;
      piece(1, 1) += 6.0 * cube(near) * depth;
      piece.row(1) += turn * beside.transpose();
      piece.col(1) += turn * beside;
      piece *= pair.scale;
      sink.add(pair.upper, pair.upper, piece);
      sink.add(pair.lower, pair.lower, piece);
      sink.add(pair.upper, pair.lower, -piece);
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    moving_.clear();
    for (const Pair& pair : pairs_) {
      if (moving[pair.upper] || moving[pair.lower]) moving_.push_back(pair);
    }
  }

 private:
  struct Pair {
    int upper = 0;
    int lower = 0;
    double gap_mm = 0.0;  // d
    double scale = 0.0;   // what stands before w
  };

  Vec3 near_per_mm2_;  // (1 / R_x^2, 0, 1 / R_z^2)
  std::vector<Pair> pairs_;
  std::vector<Pair> moving_;  // those with an end that moves
};

}  // namespace

Effect make_lip_contact_effect() {
  Effect effect;
  effect.name = "lip_contact";
  effect.what = "lips stop at each other; for mouths that close or press";
  effect.parameters = {
      {"clearance_mm",
       0.3,
       0.0,
       3.0,
       "where contact begins; at 0 lips sink into each other, above 1 they keep a slit open"},
      {"stiffness_kpa",
       2000.0,
       1.0,
       1e6,
       "pressure 1 mm beyond; below 200 lips sink into each other, above 1e5 steps of the solvers "
       "become short"},
      {"reach_along_mm",
       6.0,
       1.0,
       20.0,
       "how far beside each other along the mouth points of the lips still meet; below half an "
       "edge "
       "of the surface they slip through, above 10 a smile is held down"},
      {"reach_across_mm",
       10.0,
       1.0,
       20.0,
       "the same from front to back, the thickness of the lips; below 6 strong lips slip past each "
       "other"},
  };
  effect.called_for_when = "jaw or lip muscles bring the lips together";
  effect.internal = false;
  effect.build = [](const EffectValues& values,
                    const Anatomy& anatomy,
                    const Lattice& lattice,
                    Effects& effects) {
    effects.file(std::make_shared<LipContact>(values, anatomy, lattice));
  };
  return effect;
}

}  // namespace zygoma
