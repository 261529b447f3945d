#include "src/render/skin_texture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zygoma {
namespace {

// While levels are made, places 3 and 4 hold the heights of detail and furrow.
constexpr int kDetail = 3;
constexpr int kFurrow = 4;

SkinTexture::Level painted(const Skin& skin) {
  std::array<float, 256> linear{};
  for (int i = 0; i < 256; ++i) {
    const double c = i / 255.0;
    linear[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  const Texture& albedo = skin.albedo;
  const Relief& relief = skin.relief;
  SkinTexture::Level level{albedo.width, albedo.height, {}};
  level.texels.assign(albedo.rgb.size() / 3, SkinTexture::Texel::Zero());
  for (std::size_t i = 0; i < level.texels.size(); ++i) {
    for (int k = 0; k < 3; ++k) level.texels[i][k] = linear[albedo.rgb[3 * i + k]];
    if (!relief.detail_mm.empty()) level.texels[i][kDetail] = relief.detail_mm[i];
    if (!relief.furrow.empty()) level.texels[i][kFurrow] = relief.furrow[i];
  }
  return level;
}

SkinTexture::Level halved(const SkinTexture::Level& finer) {
  SkinTexture::Level coarser{finer.width / 2, finer.height / 2, {}};
  coarser.texels.reserve(finer.texels.size() / 4);
  for (int row = 0; row < coarser.height; ++row) {
    for (int column = 0; column < coarser.width; ++column) {
      const auto* at = finer.texels.data() + std::size_t(2 * row) * finer.width + 2 * column;
      coarser.texels.push_back(0.25F * (at[0] + at[1] + at[finer.width] + at[finer.width + 1]));
    }
  }
  return coarser;
}

// Heights become slopes, per unit of u and v.
void differentiate(SkinTexture::Level& level) {
  const std::vector<SkinTexture::Texel> heights = level.texels;
  const auto height = [&](int column, int row) -> const SkinTexture::Texel& {
    const int c = std::clamp(column, 0, level.width - 1);
    const int r = std::clamp(row, 0, level.height - 1);
    return heights[std::size_t(r) * level.width + c];
  };
  const float per_u = 0.5F * static_cast<float>(level.width);
  const float per_v = 0.5F * static_cast<float>(level.height);
  for (int row = 0; row < level.height; ++row) {
    for (int column = 0; column < level.width; ++column) {
      SkinTexture::Texel& texel = level.texels[std::size_t(row) * level.width + column];
      const auto& left = height(column - 1, row);
      const auto& right = height(column + 1, row);
      const auto& up = height(column, row - 1);
      const auto& down = height(column, row + 1);
      const float furrow = texel[kFurrow];
      texel[3] = per_u * (right[kDetail] - left[kDetail]);
      texel[4] = per_v * (down[kDetail] - up[kDetail]);
      texel[5] = per_u * (right[kFurrow] - left[kFurrow]);
      texel[6] = per_v * (down[kFurrow] - up[kFurrow]);
      texel[7] = furrow;
    }
  }
}

}  // namespace

SkinTexture::SkinTexture(const Skin& skin) {
  levels_.push_back(painted(skin));
  while (levels_.back().width > 64 && levels_.back().width % 2 == 0 &&
         levels_.back().height % 2 == 0) {
    levels_.push_back(halved(levels_.back()));
  }
  for (Level& level : levels_) differentiate(level);
}

const SkinTexture::Level& SkinTexture::level(double texels_per_px) const {
  const int wanted = static_cast<int>(std::lround(std::log2(std::max(1.0, texels_per_px))));
  return levels_[std::min(wanted, static_cast<int>(levels_.size()) - 1)];
}

SkinTexture::Texel SkinTexture::at(const Level& level, const Eigen::Vector2f& uv) {
  const float x = std::clamp(uv.x() * static_cast<float>(level.width) - 0.5F,
                             0.0F,
                             static_cast<float>(level.width) - 1.001F);
  const float y = std::clamp(uv.y() * static_cast<float>(level.height) - 0.5F,
                             0.0F,
                             static_cast<float>(level.height) - 1.001F);
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float u = x - static_cast<float>(column);
  const float v = y - static_cast<float>(row);
  const Texel* at = level.texels.data() + std::size_t(row) * level.width + column;
  const Texel high = at[0] + u * (at[1] - at[0]);
  const Texel low = at[level.width] + u * (at[level.width + 1] - at[level.width]);
  return high + v * (low - high);
}

}  // namespace zygoma
