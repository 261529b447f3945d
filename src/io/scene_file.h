// Scene files: a simulation as JSON (docs/formats.md, "Scenes"). Everything that is left out has
// its usual value; everything that is there must be known and in range.
#pragma once

#include <string>

#include "face/scene.h"

namespace zygoma {

// Throws InputError in one line, "FILE: tissue.layers[1].modulus_kpa: VALUE, expected WHAT".
Scene read_scene(const std::string& path);

// The motion alone: {"frames_per_s": 30, "keys": [{"time_s": 0.5, "pose": "6+12"}, ...]}.
Motion read_keyframes(const std::string& path);

}  // namespace zygoma
