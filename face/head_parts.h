// What is not skin: eyeballs, teeth, tongue and the dark of the mouth.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/head_shape.h"

namespace zygoma {

// The arches on which the teeth stand, after the warp of the identity.
Teeth make_teeth(const HeadShape& shape);

std::vector<RigidPart> make_rigid_parts(const HeadShape& shape, const Identity& identity);

}  // namespace zygoma
