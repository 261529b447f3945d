// The text of `zygoma COMMAND --help`: two columns, wrapped to 80 characters.
#pragma once

#include <string>
#include <vector>

namespace zygoma {

struct HelpEntry {
  std::string term;  // "-o,--output FOLDER"
  std::string text;
};

// One entry per line, the texts in a column of their own; a term that is too long for its column
// has a line to itself.
std::string two_columns(const std::vector<HelpEntry>& entries);

// Broken between words into lines of at most `width` characters, each after the first indented.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

}  // namespace zygoma
