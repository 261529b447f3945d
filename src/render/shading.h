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

struct ShadePoint {
  Eigen::Vector3f normal;
  Eigen::Vector3f to_camera;
  Colour albedo;
  float gloss = 0.0F;    // 0: skin, > 0: wet or hard
  float ambient = 1.0F;  // open share of the hemisphere
  float key = 1.0F;      // visible share of the key light
  float shine = 1.0F;    // of skin: strength of its highlights
};

class Shader {
 public:
  // Lights are given in the camera's frame and turned into the face's.
  Shader(const Lighting& lighting, const Eigen::Matrix3f& face_from_camera);
  Colour operator()(const ShadePoint& point) const;
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
