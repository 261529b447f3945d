// The standard muscles of the face, for any head.
//
// The table holds positions over the face only (x, y; frontal view, millimetres at a pupil distance
// of 63): the positions of Waters' own geometric face, moved where anatomy says otherwise. Depth is
// taken from the head at hand: the skin end lies on the surface, the bone end below it. A function
// of the caller carries the canonical face onto the actual one, so that every muscle keeps its
// place relative to eyes, nose and mouth whatever the identity.
//
// Radius and shortening are chosen together: one muscle alone does not fold the tissue over as long
// as s ||m|| pi / (2 a) < 1 (derived from equations (3) and (4)).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "face/geometry.h"
#include "face/muscle.h"

namespace zygoma {

// Canonical landmarks that `head_xy_from_canonical_xy` has to meet, mm, subject's left (+x): pupil
// (31.5, 0), inner brow end (8, 16), middle (35, 16), outer end (58, 20), nose wing (17, -44),
// mouth corner (28, -77), stomion (0, -76), pogonion (0, -118), hairline (0, 76).
//
// Both sides, _L then _R of each muscle; every right muscle is the mirror image of the left one if
// the head is symmetric. Radii grow with the head (mean scale of the map around the attachment).
std::vector<Muscle> standard_muscles(const SurfaceMesh& surface,
                                     const std::function<Vec2(Vec2)>& head_xy_from_canonical_xy);

// Their names in that order.
std::vector<std::string> standard_muscle_names();

// The muscle of that name, or both of a pair named without a side. Throws InputError(WHERE + ...)
// naming them all if there is none.
std::vector<std::string> muscles_meant(const std::string& where, const std::string& name);

}  // namespace zygoma
