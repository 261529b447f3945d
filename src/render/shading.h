// How a point of the head reflects light: wrapped diffuse whose terminator is reddish (light that
// wandered under the skin), two soft highlights with Schlick's Fresnel, hemisphere ambient tinted
// where surfaces face each other, rim light from behind.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "src/render/renderer.h"

namespace zygoma {

using Colour = Eigen::Vector3f;

// Sixteen points at once, each quantity in a row of its own.
constexpr int kLanes = 16;
using Lanes = Eigen::Array<float, kLanes, 1>;
struct ShadePacket {
  std::array<Lanes, 3> normal;     // unit
  std::array<Lanes, 3> to_camera;  // unit
  std::array<Lanes, 3> albedo;
  Lanes gloss;    // 0: skin, > 0: wet or hard
  Lanes ambient;  // open share of the hemisphere
  Lanes key;      // visible share of the key light
  Lanes shine;    // of skin: strength of its highlights
};

inline Lanes dot(const std::array<Lanes, 3>& a, const std::array<Lanes, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

class Shader {
 public:
  // Lights are given in the camera's frame and turned into the face's.
  Shader(const Lighting& lighting, const Eigen::Matrix3f& face_from_camera);
  std::array<Lanes, 3> operator()(const ShadePacket& packet) const;
  const Eigen::Vector3f& key_direction() const { return key_; }

 private:
  Eigen::Vector3f key_;
  Eigen::Vector3f fill_;
  Eigen::Vector3f rim_left_;
  Eigen::Vector3f rim_right_;
  Eigen::Vector3f up_;
  Colour key_colour_;
  Colour fill_colour_;
  Colour rim_colour_;
  Colour sky_colour_;
  Colour ground_colour_;
};

// Linear light to 8-bit sRGB with a soft shoulder, by table.
class ToneCurve {
 public:
  ToneCurve();
  std::uint8_t operator()(float linear) const {
    const float s = linear * kScale + 0.5F;
    return table_[s <= 0.0F ? 0 : s >= kSize - 1 ? kSize - 1 : static_cast<int>(s)];
  }

 private:
  static constexpr int kSize = 8192;
  static constexpr float kScale = 4096.0F;
  std::array<std::uint8_t, kSize> table_{};
};

}  // namespace zygoma
