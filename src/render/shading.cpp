#include "src/render/shading.h"

#include <algorithm>
#include <cmath>

namespace zygoma {
namespace {

float power(float x, int exponent) {
  float result = 1.0F;
  for (; exponent > 0; exponent >>= 1) {
    if (exponent & 1) result *= x;
    x *= x;
  }
  return result;
}

float wrapped(float cosine, float wrap) { return std::max(0.0F, (cosine + wrap) / (1.0F + wrap)); }

float positive(float x) { return std::max(0.0F, x); }

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

Colour Shader::operator()(const ShadePoint& point) const {
  const Eigen::Vector3f& n = point.normal;
  const float facing = positive(n.dot(point.to_camera));
  const bool skin = point.gloss <= 0.0F;

  const float key_cosine = n.dot(key_);
  const float fill_cosine = n.dot(fill_);
  Colour light;
  if (skin) {
    // Red light travels further under the skin, so it wraps further round.
    light = key_colour_.cwiseProduct(
        Colour(wrapped(key_cosine, 0.30F), wrapped(key_cosine, 0.14F), wrapped(key_cosine, 0.09F)));
    const float s = point.key;
    light = light.cwiseProduct(Colour(0.14F + 0.86F * s, 0.05F + 0.95F * s, 0.03F + 0.97F * s));
  } else {
    light = key_colour_ * (wrapped(key_cosine, 0.15F) * point.key);
  }
  const float open = point.ambient;
  light += fill_colour_ * (wrapped(fill_cosine, 0.4F) * (0.35F + 0.65F * open));
  const float sky = 0.5F + 0.5F * n.dot(up_);
  // Hollows of the skin light themselves with their own colour.
  const Colour hollow =
      skin ? Colour(std::sqrt(open), open, 0.95F * open) : Colour(open, open, open);
  light += (ground_colour_ + sky * (sky_colour_ - ground_colour_)).cwiseProduct(hollow);
  const float edge = power(1.0F - facing, 3);
  const float rim = positive(n.dot(rim_left_)) + positive(n.dot(rim_right_));
  light += rim_colour_ * (rim * (0.4F + 0.9F * edge) * open);

  Colour colour = point.albedo.cwiseProduct(light);
  const Eigen::Vector3f half = (key_ + point.to_camera).normalized();
  const float half_cosine = positive(n.dot(half));
  const float fresnel = 0.028F + 0.972F * power(1.0F - positive(half.dot(point.to_camera)), 5);
  const float visible = point.key * positive(std::min(1.0F, 4.0F * key_cosine));
  if (skin) {
    const float lobes = 2.6F * power(half_cosine, 14) + 3.2F * power(half_cosine, 48);
    colour += key_colour_ * (point.shine * fresnel * lobes * visible);
    colour += sky_colour_ * (0.16F * point.shine * edge * open);
  } else {
    const float lobes = 60.0F * power(half_cosine, 512) + 1.5F * power(half_cosine, 40);
    colour += key_colour_ * (point.gloss * fresnel * lobes * visible);
    const Eigen::Vector3f half_fill = (fill_ + point.to_camera).normalized();
    colour += fill_colour_ * (point.gloss * 1.2F * power(positive(n.dot(half_fill)), 300) * open);
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
