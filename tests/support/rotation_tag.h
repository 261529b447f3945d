// An MP4 that says it has to be turned, as telephones write.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "tests/src/scratch_folder.h"

namespace zygoma {

// Puts a 90 degree turn into the track header of an MP4.
inline void tag_as_rotated(const std::string& path) {
  std::string bytes = bytes_of(path);
  const auto box = bytes.find("tkhd");
  ASSERT_NE(box, std::string::npos);
  const std::int32_t matrix[9] = {0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30};
  for (int i = 0; i < 9; ++i) {
    for (int byte = 0; byte < 4; ++byte) {
      bytes[box + 44 + 4 * i + byte] =
          static_cast<char>(static_cast<std::uint32_t>(matrix[i]) >> (24 - 8 * byte) & 255u);
    }
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace zygoma
