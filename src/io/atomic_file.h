// A text file that appears under its name only when it is complete: written to PATH.part and
// renamed by commit(); removed by the destructor otherwise.
#pragma once

#include <fstream>
#include <string>

namespace zygoma {

class AtomicFile {
 public:
  explicit AtomicFile(std::string path);  // throws InputError naming the path
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return stream_; }
  void commit();  // throws InputError when the disk did not take it all

 private:
  std::string path_;
  std::ofstream stream_;
  bool committed_ = false;
};

}  // namespace zygoma
