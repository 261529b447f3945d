// What is not skin: eyeballs, teeth, tongue, ears, the back of the head, a shirt.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/head_shape.h"

namespace zygoma {

// The arches on which the teeth stand, after the warp of the identity.
Teeth make_teeth(const HeadShape& shape);

std::vector<RigidPart> make_rigid_parts(const HeadShape& shape, const Identity& identity);

}  // namespace zygoma
