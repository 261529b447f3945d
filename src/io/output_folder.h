// The folder a command writes into.
#pragma once

#include <string>

namespace zygoma {

// Creates the folder, with those above it, if it is not there, and tries whether files can be
// written into it, before hours of work depend on that. Throws InputError naming the folder and
// what to do.
void prepare_output_folder(const std::string& path);

}  // namespace zygoma
