#include "src/io/output_folder.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "src/base/check.h"
#include "src/io/text.h"

namespace zygoma {

void prepare_output_folder(const std::string& path) {
  const std::string advice = "; choose another output folder";
  require(!path.empty(), "output folder: the name is empty" + advice);

  std::error_code failure;
  const bool exists = std::filesystem::exists(path, failure);
  require(!exists || std::filesystem::is_directory(path, failure),
          path + ": is a file, expected a folder to write into" + advice);
  if (!exists) {
    std::filesystem::create_directories(path, failure);
    require(!failure, path + ": cannot be created (" + failure.message() + ")" + advice);
  }

  const std::string probe = (std::filesystem::path(path) / ".zygoma_write_test.part").string();
  errno = 0;
  const bool writable = std::ofstream(probe).is_open();
  require(writable, path + ": cannot be written into (" + system_reason(errno) + ")" + advice);
  std::remove(probe.c_str());
}

}  // namespace zygoma
