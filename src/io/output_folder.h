// The folder a command writes into, and what it must not overwrite.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace zygoma {

// Creates the folder, with those above it, if it is not there, and tries whether files can be
// written into it, before hours of work depend on that. What was created and is still empty at the
// end is removed again: a command that fails on its input leaves nothing behind.
class OutputFolder {
 public:
  explicit OutputFolder(const std::string& path);  // throws InputError: which folder, what to do
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // The path of a file in it.
  std::string operator/(const std::string& name) const;

 private:
  struct Created {
    ~Created();
    std::vector<std::filesystem::path> folders;  // each in the one before
  };

  std::filesystem::path path_;
  Created created_;
};

// Throws InputError when writing `output` would replace the file `input` that is being read.
void require_not_the_input(const std::string& output, const std::string& input);

}  // namespace zygoma
