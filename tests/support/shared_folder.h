// Where the clips and meshes are that are not part of the project: ../shared, or the folder that
// the environment variable ZYGOMA_SHARED names. Tests that need them skip where they are missing.
#pragma once

#include <cstdlib>
#include <string>

namespace zygoma {

inline std::string shared_folder() {
  const char* given = std::getenv("ZYGOMA_SHARED");
  return given != nullptr ? given : std::string(ZYGOMA_SOURCE_DIR) + "/../shared";
}

}  // namespace zygoma
