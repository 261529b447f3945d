// The painted skin of the default head: one albedo picture over the chart's domain.
//
// Everything is painted where the shape has it (lips, brows, lashes, hairline), in the domain, so
// that it moves with the skin. Coarse colour (blood in cheeks, nose and lips, the cooler beard and
// eye zones) is a sum of smooth spots; fine colour is strokes (brow hairs, hair, lashes) and seeded
// noise (pores, freckles, blotches).
#pragma once

#include <functional>

#include "face/anatomy.h"
#include "face/head_shape.h"

namespace zygoma {

// Texture coordinates: the middle of the face gets more texels than the back of the head.
Eigen::Vector2f uv_from_domain(const Vec2& domain_mm);
Vec2 domain_from_uv(const Eigen::Vector2f& uv);

// Visits all texels of a picture of the skin: number, domain, and frontal picture of the default
// head with x as its magnitude.
void over_texels(const HeadShape& shape,
                 int size_px,
                 const std::function<void(std::size_t, const Vec2&, const Vec2&)>& paint);

Texture paint_skin(const HeadShape& shape, const Identity& identity, int size_px);

// Hair of a thickness in millimetres over skin, sRGB; strands run away from the face. The domain
// may go on behind the outline.
Eigen::Vector3f hair_over_skin(const Identity& identity,
                               const Vec2& domain_mm,
                               double thick_mm,
                               const Eigen::Vector3f& skin);

// sRGB in [0, 1] to linear.
Eigen::Vector3f linear_from_srgb(const Eigen::Vector3f& srgb);

}  // namespace zygoma
