#include "src/synthetic/person.h"

#include <algorithm>
#include <cmath>

#include "src/synthetic/random.h"

namespace zygoma {

Identity draw_identity(std::uint32_t seed) {
  RandomStream random(seed, 2);
  Identity identity;
  identity.face_width = random.uniform(0.94, 1.07);
  identity.face_height = random.uniform(0.95, 1.06);
  identity.jaw_width = random.uniform(0.92, 1.08);
  identity.nose_length = random.uniform(0.93, 1.08);
  identity.nose_width = random.uniform(0.92, 1.1);
  identity.lip_fullness = random.uniform(0.85, 1.2);
  identity.brow_height_mm = random.uniform(-2.0, 2.0);
  identity.eye_distance = random.uniform(0.96, 1.04);
  identity.chin_length = random.uniform(0.94, 1.07);
  const float dark = static_cast<float>(random.uniform(0.0, 1.0));
  identity.skin_tone = (1.0F - dark) * Eigen::Vector3f(0.86F, 0.66F, 0.55F) +
                       dark * Eigen::Vector3f(0.52F, 0.36F, 0.27F);
  const float blond = static_cast<float>(random.uniform(0.0, 1.0)) * (1.0F - dark);
  identity.hair_tone = (1.0F - blond) * Eigen::Vector3f(0.10F, 0.07F, 0.05F) +
                       blond * Eigen::Vector3f(0.38F, 0.27F, 0.16F);
  identity.texture_seed = static_cast<std::uint32_t>(random.next());
  identity.stubble = std::max(0.0, random.uniform(-1.0, 0.8));  // a minority
  return identity;
}

Lighting draw_lighting(std::uint32_t seed) {
  RandomStream random(seed, 3);
  Lighting lighting;
  lighting.key_direction =
      Vec3(random.uniform(-0.8, 0.8), random.uniform(0.3, 0.9), random.uniform(0.7, 1.1));
  lighting.key = random.uniform(0.85, 1.15);
  lighting.fill = random.uniform(0.7, 1.2);
  lighting.rim = random.uniform(0.5, 1.2);
  lighting.ambient = random.uniform(0.8, 1.2);
  const auto grey = [&](double low, double high) {
    const double level = random.uniform(low, high);
    return Eigen::Vector3f(static_cast<float>(level * random.uniform(0.9, 1.1)),
                           static_cast<float>(level * random.uniform(0.9, 1.1)),
                           static_cast<float>(level * random.uniform(0.9, 1.1)));
  };
  lighting.background_top = grey(0.25, 0.75);
  lighting.background_bottom = grey(0.12, 0.5);
  return lighting;
}

Sway::Sway(std::uint32_t seed, double amount) {
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  constexpr std::array<double, 6> kAmplitude{
      3.0 * kDegree, 2.0 * kDegree, 3.0 * kDegree, 8.0, 5.0, 12.0};
  RandomStream random(seed, 4);
  for (std::size_t axis = 0; axis < waves_.size(); ++axis) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double share = i == 0 ? 0.7 : 0.3;
      waves_[axis][i] = {amount * share * kAmplitude[axis] * random.uniform(0.6, 1.0),
                         random.uniform(0.8, 1.6) * (i == 0 ? 1.0 : 2.3),
                         random.uniform(0.0, 6.283185307179586)};
    }
  }
}

double Sway::value(std::size_t axis, double time_s) const {
  double sum = 0.0;
  for (const Wave& wave : waves_[axis]) {
    sum += wave.amplitude * std::sin(wave.rate_rad_per_s * time_s + wave.phase_rad);
  }
  return sum;
}

Eigen::Isometry3d Sway::head_at(double time_s) const {
  const Vec3 neck(0.0, -90.0, -90.0);
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(value(0, time_s), Vec3::UnitY()) *
                                  Eigen::AngleAxisd(value(1, time_s), Vec3::UnitX()) *
                                  Eigen::AngleAxisd(value(2, time_s), Vec3::UnitZ());
  const Vec3 shift(value(3, time_s), value(4, time_s), value(5, time_s));
  return Eigen::Translation3d(neck + shift) * turn * Eigen::Translation3d(-neck);
}

}  // namespace zygoma
