// Corrections of contours by hand as a file (docs/formats.md): one JSON object per line, appended
// as they are made,
//
//   {"id": 1, "frame": 57, "contour": "upper_lip", "kind": "spring", "s": 0.0,
//    "x": 212.4, "y": 301.7}                                             (in one line)
//   {"id": 2, "frame": 57, "contour": "brow_left", "kind": "pin", "s": 1, "x": 318, "y": 140.2,
//    "k": 20, "radius": 0.1}                                             (in one line)
//   {"id": 3, "undo": 1}
//
// An undo takes away the event of that id, which may itself be an undo.
#pragma once

#include <string>
#include <vector>

#include "tracker/correction.h"

namespace zygoma {

// The corrections in force, in order of id. Throws InputError naming file, line and value.
std::vector<Correction> read_corrections(const std::string& path);

}  // namespace zygoma
