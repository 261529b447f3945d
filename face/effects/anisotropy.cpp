// Anisotropy of the skin (paper, section 2): less stiff along Langer's lines than across them.
//
// The lines run across the pull of the muscles below, as wrinkles do. With Q the traceless tensor
// of the pulls in the tangent plane, scaled to eigenvalues +1 (across the lines) and -1 (along
// them), a spring in direction d gets the stiffness
//
//   alpha' = alpha (1 + a d.Q d),    a = (ratio - 1) / (ratio + 1)
//
// so that stiffness across is `ratio` times that along, and the mean over all directions is kept.
// Where no muscle reaches, the lines go on from those around them. Springs that touch the surface
// are concerned: epidermis and dermis. Lengths at rest are not, hence rest stays exact.
#include <cmath>

#include "face/effect.h"
#include "face/muscle_field.h"

namespace zygoma {
namespace {

using Tensors = std::vector<Eigen::Matrix3d>;  // per surface vertex

// What is left of a tensor in the plane across n, without its mean.
Eigen::Matrix3d in_plane(const Eigen::Matrix3d& q, const Vec3& n) {
  const Eigen::Matrix3d plane = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Matrix3d flat = plane * q * plane;
  return flat - 0.5 * flat.trace() * plane;
}

Tensors pulls(const Anatomy& anatomy, const Lattice& lattice) {
  Tensors q(lattice.num_vertices, Eigen::Matrix3d::Zero());
  for (const std::vector<MusclePull>& muscle : make_muscle_field(anatomy, lattice).pulls) {
    for (const MusclePull& pull : muscle) {
      const Column& column = lattice.columns[pull.column];
      for (int k = 0; k < 3; ++k) {
        q[column.vertex[k]] +=
            column.weight[k] * pull.displacement_mm * pull.displacement_mm.transpose();
      }
    }
  }
  return q;
}

// To eigenvalues +-1 unless it is next to nothing.
Eigen::Matrix3d scaled(const Eigen::Matrix3d& q) {
  constexpr double kNothing = 1e-3;
  return q / std::sqrt(0.5 * q.squaredNorm() + kNothing * kNothing);
}

// Eigenvalue +1 across the lines, -1 along them, 0 along the normal. Every vertex hears what its
// neighbours say, against the pull of its own, if it has one.
Tensors line_tensors(const Anatomy& anatomy, const Lattice& lattice) {
  constexpr int kRounds = 60;
  constexpr int kNormalRounds = 2;
  constexpr double kEvenMm2 = 10.0;  // squared pull that weighs as much as all neighbours together
  const std::vector<Vec3> normal =
      smooth_normals(anatomy.surface, lattice.neighbors, kNormalRounds);
  Tensors own = pulls(anatomy, lattice);
  for (std::size_t v = 0; v < own.size(); ++v) own[v] = in_plane(own[v] / kEvenMm2, normal[v]);
  Tensors q(own.size(), Eigen::Matrix3d::Zero());
  for (int round = 0; round < kRounds; ++round) {
    Tensors next = own;
    for (std::size_t v = 0; v < q.size(); ++v) {
      Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
      for (const int u : lattice.neighbors[v]) mean += q[u];
      next[v] += mean / static_cast<double>(lattice.neighbors[v].size());
      next[v] = scaled(in_plane(next[v], normal[v]));
    }
    q = std::move(next);
  }
  return q;
}

void scale(BiphasicLaw& law, double factor) {
  law.alpha *= factor;
  law.stiffening *= factor;
  law.slackening *= factor;
}

void shape(const EffectValues& values, const Anatomy& anatomy, Lattice& lattice) {
  const double a = (values["ratio"] - 1.0) / (values["ratio"] + 1.0);
  const Tensors q = line_tensors(anatomy, lattice);
  for (Spring& spring : lattice.springs) {
    const Vec3 r = lattice.rest_mm[spring.j] - lattice.rest_mm[spring.i];
    const double length2 = r.squaredNorm();
    int num_ends = 0;
    double along = 0.0;
    for (const int end : {spring.i, spring.j}) {
      if (end >= lattice.num_vertices || length2 == 0.0) continue;
      along += r.dot(q[end] * r) / length2;
      ++num_ends;
    }
    if (num_ends > 0) scale(spring.law, 1.0 + a * along / num_ends);
  }
}

}  // namespace

Effect make_anisotropy_effect() {
  Effect effect;
  effect.name = "anisotropy";
  effect.what = "skin is stiffer across Langer's lines than along them: creases follow the lines";
  effect.parameters = {
      {"ratio",
       2.0,
       0.2,
       5.0,
       "stiffness across the lines against along them; 1 = the same, below 1 the other way round; "
       "at "
       "the ends springs in the soft direction hardly resist folding"},
  };
  effect.shape = shape;
  return effect;
}

}  // namespace zygoma
