#include "src/cli/help_text.h"

#include <algorithm>
#include <sstream>

namespace zygoma {
namespace {

constexpr std::size_t kLineWidth = 80;
constexpr std::size_t kMargin = 2;
constexpr std::size_t kWidestTerm = 24;

}  // namespace

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::istringstream words(text);
  std::string result;
  std::size_t length = 0;
  for (std::string word; words >> word;) {
    if (length > 0 && length + 1 + word.size() > width) {
      result.append(1, '\n').append(indent, ' ');
      length = 0;
    }
    if (length > 0) {
      result += ' ';
      ++length;
    }
    result += word;
    length += word.size();
  }
  return result;
}

std::string two_columns(const std::vector<HelpEntry>& entries) {
  std::size_t widest = 0;
  for (const HelpEntry& entry : entries) {
    if (entry.term.size() <= kWidestTerm) widest = std::max(widest, entry.term.size());
  }
  const std::size_t column = kMargin + widest + 2;
  std::string result;
  for (const HelpEntry& entry : entries) {
    result.append(kMargin, ' ').append(entry.term);
    if (entry.term.size() <= widest) {
      result.append(column - kMargin - entry.term.size(), ' ');
    } else {
      result.append(1, '\n').append(column, ' ');
    }
    result.append(wrapped(entry.text, kLineWidth - column, column)).append(1, '\n');
  }
  return result;
}

}  // namespace zygoma
