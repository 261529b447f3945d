// Skull contact: the fascia slides over the bone and never enters it.
//
//   E = sum_f A S d / 3 (max(0, d - s) / d)^3,    s = (x_f - x_b) . n
//
// x_f is the fascia node of a column, x_b its bone node and n the normal of the bone there, from
// the bone nodes around it; d is a share of the distance at rest, so that rest is free of force. A
// is the column's area and S the pressure at which the fascia would reach the bone. The cubic keeps
// second derivatives continuous where contact begins, and with them the sensitivities. One-sided
// penalty instead of the paper family's projection of forces: that is no energy.
//
// n turns with the jaw and with bone that slides; its derivatives by the bone nodes are complete,
// so that what these do to the free nodes is, too.
#include <cmath>
#include <map>

#include "face/effect.h"

namespace zygoma {
namespace {

using Corners = std::array<int, 2>;  // two bone nodes next to each other, seen from a third

// For every column the bone nodes around its own, counter-clockwise seen from outside; empty where
// there is no bone.
std::vector<std::vector<Corners>> bone_rings(const Anatomy& anatomy, const Lattice& lattice) {
  std::vector<std::vector<Corners>> rings(lattice.columns.size());
  const auto bone = [&](int column) { return lattice.columns[column].bone(); };
  std::map<std::array<int, 2>, int> triangle_of_edge;
  for (std::size_t t = 0; t < anatomy.surface.triangles.size(); ++t) {
    const Triangle& tri = anatomy.surface.triangles[t];
    for (int e = 0; e < 3; ++e) {
      const int next = tri[(e + 1) % 3];
      triangle_of_edge[{tri[e], next}] = static_cast<int>(t);
      if (!lattice.columns[tri[e]].on_bone) continue;
      rings[tri[e]].push_back({bone(next), bone(tri[(e + 2) % 3])});
    }
  }
  // Where columns hang below triangles, neighbours share an edge.
  for (std::size_t t = 0; t + lattice.num_vertices < lattice.columns.size(); ++t) {
    const Triangle& tri = anatomy.surface.triangles[t];
    std::array<int, 3> across{-1, -1, -1};
    for (int e = 0; e < 3; ++e) {
      const auto found = triangle_of_edge.find({tri[(e + 1) % 3], tri[e]});
      if (found != triangle_of_edge.end()) across[e] = lattice.num_vertices + found->second;
    }
    for (int e = 0; e < 3; ++e) {
      const int next = across[(e + 1) % 3];
      if (across[e] < 0 || next < 0) continue;
      rings[lattice.num_vertices + t].push_back({bone(across[e]), bone(next)});
    }
  }
  return rings;
}

// Normal of the bone; next to no length where the bone around has no area.
struct BoneNormal {
  Vec3 n;
  double length = 0.0;  // of the area vector it comes from
};

class SkullContact final : public EnergyTerm {
 public:
  SkullContact(const EffectValues& values, const Anatomy& anatomy, const Lattice& lattice)
      : lattice_(lattice) {
    constexpr double kSteepest = 0.3;  // cosine between column and bone normal
    const std::vector<std::vector<Corners>> rings = bone_rings(anatomy, lattice);
    for (std::size_t c = 0; c < rings.size(); ++c) {
      const Column& column = lattice.columns[c];
      if (rings[c].empty() || column.is_thin() || is_flap(anatomy, column)) continue;
      Site site{column.fascia(), column.bone(), rings[c]};
      site.softening = kSofteningShare * area_vector(site, lattice.rest_mm).norm();
      const Vec3 up = lattice.rest_mm[site.fascia] - lattice.rest_mm[site.bone];
      const double rest = up.dot(normal(site, lattice.rest_mm).n);
      if (rest < kSteepest * up.norm()) continue;
      site.distance_mm = values["distance_share"] * rest;
      site.scale =
          values["stiffness_kpa"] * column.area_mm2 / (3.0 * site.distance_mm * site.distance_mm);
      sites_.push_back(std::move(site));
    }
    restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    double energy = 0.0;
    for (const int k : moving_) {
      const Site& site = sites_[k];
      const BoneNormal bone = normal(site, x);
      const Vec3 up = x[site.fascia] - x[site.bone];
      const double depth = site.distance_mm - up.dot(bone.n);
      if (depth <= 0.0) continue;
      energy += site.scale * depth * depth * depth;
      const double first = -3.0 * site.scale * depth * depth;  // by the distance
      gradient.segment<3>(3 * site.fascia) += first * bone.n;
      gradient.segment<3>(3 * site.bone) -= first * bone.n;
      const Vec3 turn = (0.5 * first / bone.length) * (up - bone.n.dot(up) * bone.n);
      for (const auto& [a, b] : site.ring) {
        const Vec3 by_a = (x[b] - x[site.bone]).cross(turn);
        const Vec3 by_b = turn.cross(x[a] - x[site.bone]);
        gradient.segment<3>(3 * a) += by_a;
        gradient.segment<3>(3 * b) += by_b;
        gradient.segment<3>(3 * site.bone) -= by_a + by_b;
      }
    }
    return energy;
  }

  // Without the pieces between bone nodes, which nobody asks for.
  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const override {
    for (const Site& site : sites_) {
      if (!sink.looks_at(site.fascia, site.bone)) {
        sink.skip(2 + 3 * site.ring.size());
        continue;
      }
      const BoneNormal bone = normal(site, x);
      const Vec3 up = x[site.fascia] - x[site.bone];
      const double depth = std::max(0.0, site.distance_mm - up.dot(bone.n));
      const double first = -3.0 * site.scale * depth * depth;
      const double second = 6.0 * site.scale * depth;
      const Eigen::Matrix3d push = second * bone.n * bone.n.transpose();
      sink.add(site.fascia, site.fascia, push);
      sink.add(site.fascia, site.bone, -push);
      // How a change of the area vector changes the force on the fascia.
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - bone.n * bone.n.transpose();
      const Eigen::Matrix3d turn =
          (0.5 / bone.length) * (second * bone.n * (across * up).transpose() + first * across);
      for (const auto& [a, b] : site.ring) {
        const Eigen::Matrix3d by_a = -turn * cross_matrix(x[b] - x[site.bone]);
        const Eigen::Matrix3d by_b = turn * cross_matrix(x[a] - x[site.bone]);
        sink.add(site.fascia, a, by_a);
        sink.add(site.fascia, b, by_b);
        sink.add(site.fascia, site.bone, -by_a - by_b);
      }
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    moving_.clear();
    for (std::size_t k = 0; k < sites_.size(); ++k) {
      if (moving[sites_[k].fascia]) moving_.push_back(static_cast<int>(k));
    }
  }

 private:
  static constexpr double kSofteningShare = 1e-3;  // of the area at rest

  struct Site {
    int fascia = 0;
    int bone = 0;
    std::vector<Corners> ring;
    double softening = 0.0;
    double distance_mm = 0.0;  // d
    double scale = 0.0;        // A S / (3 d^2)
  };

  // Lips and lids lie on teeth and eyeball, not on bone.
  static bool is_flap(const Anatomy& anatomy, const Column& column) {
    for (const int v : column.vertex) {
      if (anatomy.region[v] != Region::kFace) return true;
    }
    return false;
  }

  static Vec3 area_vector(const Site& site, const std::vector<Vec3>& x) {
    Vec3 area = Vec3::Zero();
    for (const auto& [a, b] : site.ring) area += (x[a] - x[site.bone]).cross(x[b] - x[site.bone]);
    return 0.5 * area;
  }

  static BoneNormal normal(const Site& site, const std::vector<Vec3>& x) {
    const Vec3 area = area_vector(site, x);
    const double length = std::sqrt(area.squaredNorm() + site.softening * site.softening);
    return {area / length, length};
  }

  const Lattice& lattice_;
  std::vector<Site> sites_;
  std::vector<int> moving_;  // sites whose fascia moves
};

}  // namespace

Effect make_skull_contact_effect() {
  Effect effect;
  effect.name = "skull_contact";
  effect.what = "fascia never enters the bone: for strong pulls over a convex skull";
  effect.parameters = {
      {"distance_share",
       0.5,
       0.05,
       0.95,
       "of the distance between fascia and bone at rest, where contact begins; near 1 it takes "
       "part "
       "in every motion, near 0 it is stiff"},
      {"stiffness_kpa",
       200.0,
       1.0,
       1e5,
       "pressure at which the fascia would reach the bone; below 50 strong muscles get through, "
       "above 1e4 steps of the solvers become short"},
  };
  effect.called_for_when = "muscles pull the fascia onto the bone";
  effect.build = [](const EffectValues& values,
                    const Anatomy& anatomy,
                    const Lattice& lattice,
                    Effects& effects) {
    effects.file(std::make_shared<SkullContact>(values, anatomy, lattice));
  };
  return effect;
}

}  // namespace zygoma
