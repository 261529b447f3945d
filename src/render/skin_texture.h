// Everything painted and carved on the skin in one lookup: albedo as linear light, the slopes of
// its fine relief and of the pattern of furrows, and the pattern's height; halved again and again,
// so that what is finer than a pixel fades instead of flickering.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "face/anatomy.h"

namespace zygoma {

class SkinTexture {
 public:
  // red, green, blue; d(detail)/du, d(detail)/dv, d(furrow)/du, d(furrow)/dv; furrow.
  using Texel = Eigen::Array<float, 8, 1>;
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<Texel> texels;
  };

  explicit SkinTexture(const Skin& skin);

  // The level for a picture of which one pixel covers so many texels.
  const Level& level(double texels_per_px) const;

  // Bilinear.
  static Texel at(const Level& level, const Eigen::Vector2f& uv);

 private:
  std::vector<Level> levels_;
};

}  // namespace zygoma
