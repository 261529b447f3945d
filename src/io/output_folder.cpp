#include "src/io/output_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fstream>

#include "src/base/check.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

constexpr const char* kAdvice = "; choose another output folder";

// The folder and those above it that are not there, outermost first.
std::vector<std::filesystem::path> missing_folders(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> missing;
  std::error_code ignored;
  for (std::filesystem::path p = path; !p.empty() && !std::filesystem::exists(p, ignored);
       p = p.parent_path()) {
    if (p.has_filename()) missing.push_back(p);  // "a/" is "a" once more
  }
  std::reverse(missing.begin(), missing.end());
  return missing;
}

}  // namespace

OutputFolder::Created::~Created() {
  std::error_code ignored;
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {
    if (!std::filesystem::remove(*folder, ignored)) return;  // has something in it
  }
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  require(!path.empty(), std::string("output folder: the name is empty") + kAdvice);
  std::error_code failure;
  require(!std::filesystem::exists(path_, failure) || std::filesystem::is_directory(path_, failure),
          path + ": is a file, expected a folder to write into" + kAdvice);
  for (const std::filesystem::path& folder : missing_folders(path_)) {
    const bool created = std::filesystem::create_directory(folder, failure);
    require(!failure, path + ": cannot be created (" + failure.message() + ")" + kAdvice);
    if (created) created_.folders.push_back(folder);
  }

  const std::string probe = *this / ".zygoma_write_test.part";
  errno = 0;
  const bool writable = std::ofstream(probe).is_open();
  require(writable, path + ": cannot be written into (" + system_reason(errno) + ")" + kAdvice);
  std::remove(probe.c_str());
}

std::string OutputFolder::operator/(const std::string& name) const {
  return (path_ / name).string();
}

void require_not_the_input(const std::string& output, const std::string& input) {
  std::error_code not_there;
  require(!std::filesystem::equivalent(output, input, not_there),
          output + ": is the input itself and would be overwritten; choose another output");
}

}  // namespace zygoma
