// Which libraries decoded, tracked and encoded: part of what repeats a run.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace zygoma {

// (name, version) pairs.
std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace zygoma
