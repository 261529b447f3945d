// Gravity: tissue hangs when the head is not upright, or is not on earth.
//
//   E = - sum_i m_i (g - g_upright) . (x_i - X_i)
//
// A face is measured upright under one g, so the authored shape already sags. Only the difference
// acts here, and the upright face stays exactly the authored one. (That its tissue is also
// pre-stressed is left out: the sag is right to first order.) An external force in the sense of the
// paper's f_i, equation (2).
#include <cmath>
#include <numbers>

#include "face/effect.h"

namespace zygoma {
namespace {

constexpr double kEarthMmPerS2 = 9806.65;

// Down, in the frame of a head that has nodded forwards and tilted towards its left shoulder.
Vec3 down(double pitch_deg, double roll_deg) {
  const double p = pitch_deg * std::numbers::pi / 180.0;
  const double r = roll_deg * std::numbers::pi / 180.0;
  return {std::cos(p) * std::sin(r), -std::cos(p) * std::cos(r), std::sin(p)};
}

class Gravity final : public EnergyTerm {
 public:
  Gravity(const EffectValues& values, const Lattice& lattice)
      : lattice_(lattice),
        change_(kEarthMmPerS2 *
                (values["magnitude_g"] * down(values["pitch_deg"], values["roll_deg"]) -
                 down(0.0, 0.0))) {}

  double add_gradient(const std::vector<Vec3>& x, Eigen::VectorXd& gradient) const override {
    double energy = 0.0;
    for (int k = 0; k < lattice_.num_free_nodes; ++k) {
      const Vec3 weight = lattice_.mass_kg[k] * change_;
      energy -= weight.dot(x[k] - lattice_.rest_mm[k]);
      gradient.segment<3>(3 * k) -= weight;
    }
    return energy;
  }

  void add_hessian(const std::vector<Vec3>& /*x*/, HessianSink& /*sink*/) const override {}

 private:
  const Lattice& lattice_;
  Vec3 change_;  // g - g_upright, mm/s^2
};

}  // namespace

Effect make_gravity_effect() {
  Effect effect;
  effect.name = "gravity";
  effect.what = "tissue hangs when the head lies, leans or falls; upright it changes nothing";
  effect.only_if_asked = "heads are upright unless the scene says otherwise";
  effect.parameters = {
      {"magnitude_g",
       1.0,
       0.0,
       10.0,
       "1 = earth, where faces are measured; 0 = weightless; above 4 soft tissue leaves the range "
       "its stiffness is meant for"},
      {"pitch_deg",
       -90.0,
       -180.0,
       180.0,
       "of the head: 0 upright, -90 lying on the back, 90 face down"},
      {"roll_deg",
       0.0,
       -180.0,
       180.0,
       "of the head: 90 = left ear down; has no meaning while pitch is 90 or -90"},
  };
  effect.internal = false;
  effect.build = [](const EffectValues& values,
                    const Anatomy& /*anatomy*/,
                    const Lattice& lattice,
                    Effects& effects) { effects.file(std::make_shared<Gravity>(values, lattice)); };
  return effect;
}

}  // namespace zygoma
