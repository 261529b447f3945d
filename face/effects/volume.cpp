// Volume preservation (paper, section 3b, the q_i of equation (2)): ground substance and fat hardly
// change their volume.
//
//   E = sum_e K/(2 V0) (V - V0)^2  +  sum_e 3 K V0 (J0 - V/V0)^3 where V/V0 < J0
//
// The print gives the term the sign of a force but the place of a gradient; here it is the gradient
// of an energy, so it can be differentiated and adds no energy of its own. The second sum is a
// barrier: springs cannot see that an element is inside out, a signed volume can. It is finite
// everywhere, so that inverted elements find their way back.
#include <algorithm>

#include "face/effect.h"
#include "face/prism.h"
#include "face/solvers/lattice_kernels.h"

namespace zygoma {
namespace {

struct Jet {  // derivatives of the energy of one element by its volume
  double energy = 0.0, first = 0.0, second = 0.0;
};

class Volume final : public EnergyTerm {
 public:
  Volume(const EffectValues& values, const Lattice& lattice)
      : lattice_(lattice),
        factor_(values["factor"]),
        barrier_start_(values["barrier_start"]),
        barrier_ratio_(values["barrier_ratio"]) {
    restrict_to(std::vector<char>(lattice.rest_mm.size(), 1));
  }

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    const double energy = moving_.energy_and_gradient(nodes_.at(x));
    nodes_.add_gradients(gradient);
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& x, HessianSink& sink) const override {
    for (const Prism& prism : lattice_.prisms) {
      const std::array<int, 6>& node = prism.node;
      if (!sink.looks_at(node[0], node[1]) && !sink.looks_at(node[2], node[3]) &&
          !sink.looks_at(node[4], node[5])) {
        sink.skip(21);
        continue;
      }
      const PrismCorners corner = corners_of(prism, x);
      PrismCorners g;
      PrismCurvature k;
      const Jet jet = energy_of(prism, prism_volume(corner, g));
      prism_curvature(corner, k);
      for (int p = 0; p < 6; ++p) {
        const Vec3 scaled = jet.second * g[p];
        sink.add(prism.node[p], prism.node[p], scaled * g[p].transpose());
        for (int q = p + 1; q < 6; ++q) {
          Eigen::Matrix3d piece = scaled * g[q].transpose() + cross_matrix(jet.first * k[p][q]);
          // Corners of a tetrahedral unit that are one node.
          if (prism.node[p] == prism.node[q]) piece += piece.transpose().eval();
          sink.add(prism.node[p], prism.node[q], piece);
        }
      }
    }
  }

  void restrict_to(const std::vector<char>& moving) override {
    std::vector<Prism> prisms;
    std::vector<char> touched(moving.size(), 0);
    for (Prism prism : lattice_.prisms) {
      prism.bulk_kpa *= factor_;
      const auto moves = [&](int node) { return moving[node] != 0; };
      if (std::none_of(prism.node.begin(), prism.node.end(), moves)) continue;
      prisms.push_back(prism);
      for (const int node : prism.node) touched[node] = 1;
    }
    nodes_.choose(touched);
    moving_ = PrismSet(prisms, lattice_.rest_mm, {barrier_start_, barrier_ratio_});
  }

 private:
  Jet energy_of(const Prism& prism, double volume) const {
    const double j = volume / prism.rest_mm3;
    const double k = factor_ * prism.bulk_kpa;
    Jet jet{0.5 * k * prism.rest_mm3 * (j - 1.0) * (j - 1.0), k * (j - 1.0), k / prism.rest_mm3};
    const double short_of = barrier_start_ - j;
    if (short_of > 0.0) {
      const double b = barrier_ratio_ * k;
      jet.energy += b * prism.rest_mm3 * short_of * short_of * short_of;
      jet.first -= 3.0 * b * short_of * short_of;
      jet.second += 6.0 * b * short_of / prism.rest_mm3;
    }
    return jet;
  }

  const Lattice& lattice_;
  double factor_;
  double barrier_start_;  // J0
  double barrier_ratio_;
  PrismSet moving_;             // those with a node that moves
  mutable TouchedNodes nodes_;  // by these
};

}  // namespace

Effect make_volume_effect() {
  Effect effect;
  effect.name = "volume";
  effect.what = "tissue keeps its volume: cheeks bulge, wrinkles form; nearly every scene needs it";
  effect.parameters = {
      {"factor", 1.0, 0.0, 100.0, "on the bulk moduli of the layers; below 0.3 volume is lost"},
      {"barrier_start", 0.3, 0.01, 0.9, "share of the rest volume where the barrier sets in"},
      {"barrier_ratio", 3.0, 0.0, 100.0, "stiffness of the barrier against the bulk modulus"},
  };
  effect.build = [](const EffectValues& values,
                    const Anatomy& /*anatomy*/,
                    const Lattice& lattice,
                    Effects& effects) { effects.file(std::make_shared<Volume>(values, lattice)); };
  return effect;
}

}  // namespace zygoma
