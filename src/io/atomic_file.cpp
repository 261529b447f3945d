#include "src/io/atomic_file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <locale>
#include <utility>

#include "src/base/check.h"
#include "src/io/text.h"

namespace zygoma {

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  std::error_code ignored;
  require(!std::filesystem::is_directory(path_, ignored),
          path_ + ": is a folder, expected a file that can be written");
  stream_.imbue(std::locale::classic());
  errno = 0;
  stream_.open(path_ + ".part", std::ios::binary | std::ios::trunc);
  require(stream_.is_open(), path_ + ": cannot be written (" + system_reason(errno) + ")");
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::remove((path_ + ".part").c_str());
}

void AtomicFile::commit() {
  errno = 0;
  stream_.close();  // flushes; what failed on the way has left a mark
  require(!stream_.fail(), path_ + ": cannot be written completely (" + system_reason(errno) + ")");
  errno = 0;
  const bool renamed = std::rename((path_ + ".part").c_str(), path_.c_str()) == 0;
  require(renamed, path_ + ": cannot be put in place (" + system_reason(errno) + ")");
  committed_ = true;
}

}  // namespace zygoma
