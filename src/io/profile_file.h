// The profile of a performer as JSON (docs/formats.md): the face at rest and the range of motion.
#pragma once

#include <string>

#include "retarget/profile.h"

namespace zygoma {

// Throws InputError naming the file when it cannot be written.
void write_profile(const std::string& path, const PerformerProfile& profile);

// Throws InputError with file, place, value and what was expected.
PerformerProfile read_profile(const std::string& path);

}  // namespace zygoma
