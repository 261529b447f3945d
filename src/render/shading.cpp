#include "src/render/shading.h"

#include <algorithm>
#include <cmath>

namespace zygoma {
namespace {

Lanes power(Lanes x, int exponent) {
  Lanes result = Lanes::Ones();
  for (; exponent > 0; exponent >>= 1) {
    if (exponent & 1) result *= x;
    x *= x;
  }
  return result;
}

Lanes positive(const Lanes& x) { return x.max(0.0F); }

Lanes wrapped(const Lanes& cosine, float wrap) {
  return positive((cosine + wrap) * (1.0F / (1.0F + wrap)));
}

Lanes along(const std::array<Lanes, 3>& v, const Eigen::Vector3f& direction) {
  return v[0] * direction.x() + v[1] * direction.y() + v[2] * direction.z();
}

// Half way between the light and the camera, not normalised, and one over its length.
struct HalfWay {
  HalfWay(const Eigen::Vector3f& light, const std::array<Lanes, 3>& to_camera)
      : direction{to_camera[0] + light.x(), to_camera[1] + light.y(), to_camera[2] + light.z()},
        per_length(dot(direction, direction).max(1e-12F).rsqrt()) {}
  Lanes cosine(const std::array<Lanes, 3>& v) const {
    return positive(dot(direction, v) * per_length);
  }
  std::array<Lanes, 3> direction;
  Lanes per_length;
};

}  // namespace

Shader::Shader(const Lighting& lighting, const Eigen::Matrix3f& face_from_camera) {
  const auto turned = [&](const Eigen::Vector3f& front) {
    const Eigen::Vector3f camera(front.x(), -front.y(), -front.z());
    return Eigen::Vector3f((face_from_camera * camera).normalized());
  };
  const Eigen::Vector3f key = lighting.key_direction.cast<float>().normalized();
  key_ = turned(key);
  fill_ = turned({-0.9F * key.x() + 0.1F, 0.10F, 0.8F});
  rim_left_ = turned({0.85F, 0.45F, -0.55F});
  rim_right_ = turned({-0.85F, 0.45F, -0.55F});
  up_ = turned({0.0F, 1.0F, 0.25F});
  key_colour_ = static_cast<float>(lighting.key) * Colour(0.98F, 0.93F, 0.86F);
  fill_colour_ = static_cast<float>(lighting.fill) * Colour(0.22F, 0.235F, 0.26F);
  rim_colour_ = static_cast<float>(lighting.rim) * Colour(0.30F, 0.33F, 0.38F);
  sky_colour_ = static_cast<float>(lighting.ambient) * Colour(0.30F, 0.31F, 0.33F);
  ground_colour_ = static_cast<float>(lighting.ambient) * Colour(0.15F, 0.13F, 0.12F);
}

std::array<Lanes, 3> Shader::operator()(const ShadePacket& packet) const {
  // Red light travels further under the skin, so it wraps further round, also into a shadow.
  constexpr std::array<float, 3> kSkinWrap{0.30F, 0.14F, 0.09F};
  constexpr std::array<float, 3> kSkinBleed{0.14F, 0.05F, 0.03F};
  const std::array<Lanes, 3>& n = packet.normal;
  const Lanes& open = packet.ambient;
  const auto skin = packet.gloss <= 0.0F;
  const bool all_skin = skin.all();
  const Lanes facing = positive(dot(n, packet.to_camera));
  const Lanes key_cosine = along(n, key_);
  const Lanes fill = wrapped(along(n, fill_), 0.4F) * (0.35F + 0.65F * open);
  const Lanes sky = 0.5F + 0.5F * along(n, up_);
  const Lanes edge = power(1.0F - facing, 3);
  const Lanes rim = (positive(along(n, rim_left_)) + positive(along(n, rim_right_))) *
                    (0.4F + 0.9F * edge) * open;
  const HalfWay half(key_, packet.to_camera);
  const Lanes half_cosine = half.cosine(n);
  const Lanes fresnel = 0.028F + 0.972F * power(1.0F - half.cosine(packet.to_camera), 5);
  const Lanes visible = packet.key * positive((4.0F * key_cosine).min(1.0F));
  const Lanes skin_lobes = packet.shine * fresnel * visible *
                           (2.6F * power(half_cosine, 14) + 3.2F * power(half_cosine, 48));
  const Lanes sheen = 0.16F * packet.shine * edge * open;
  Lanes hard_key = Lanes::Zero(), hard_lobes = Lanes::Zero(), hard_fill = Lanes::Zero();
  if (!all_skin) {
    hard_key = wrapped(key_cosine, 0.15F) * packet.key;
    hard_lobes = packet.gloss * fresnel * visible *
                 (60.0F * power(half_cosine, 512) + 1.5F * power(half_cosine, 40));
    hard_fill = packet.gloss * 1.2F * power(HalfWay(fill_, packet.to_camera).cosine(n), 300) * open;
  }
  // Hollows of the skin light themselves with their own colour.
  const std::array<Lanes, 3> hollow{open.sqrt(), open, 0.95F * open};
  std::array<Lanes, 3> colour;
  for (int k = 0; k < 3; ++k) {
    const Lanes base = fill_colour_[k] * fill + rim_colour_[k] * rim;
    const Lanes hemisphere = ground_colour_[k] + sky * (sky_colour_[k] - ground_colour_[k]);
    const Lanes soft_key =
        wrapped(key_cosine, kSkinWrap[k]) * (kSkinBleed[k] + (1.0F - kSkinBleed[k]) * packet.key);
    colour[k] = packet.albedo[k] * (key_colour_[k] * soft_key + base + hemisphere * hollow[k]) +
                key_colour_[k] * skin_lobes + sky_colour_[k] * sheen;
    if (all_skin) continue;
    const Lanes hard = packet.albedo[k] * (key_colour_[k] * hard_key + base + hemisphere * open) +
                       key_colour_[k] * hard_lobes + fill_colour_[k] * hard_fill;
    colour[k] = skin.select(colour[k], hard);
  }
  return colour;
}

ToneCurve::ToneCurve() {
  for (int i = 0; i < kSize; ++i) {
    double x = i / static_cast<double>(kScale);
    constexpr double kKnee = 0.70;  // linear below, towards 1 above
    if (x > kKnee) x = kKnee + (1.0 - kKnee) * (1.0 - std::exp(-(x - kKnee) / (1.0 - kKnee)));
    const double srgb = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    table_[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(srgb, 0.0, 1.0)));
  }
}

}  // namespace zygoma
