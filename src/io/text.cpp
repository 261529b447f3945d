#include "src/io/text.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view stripped(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

void split_cells(std::string_view line, std::vector<std::string_view>& cells) {
  for (;;) {
    const auto comma = line.find(',');
    cells.push_back(stripped(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

template <typename T>
bool parse_whole(std::string_view text, T& value) {
  const char* last = text.data() + text.size();
  const auto result = std::from_chars(text.data(), last, value);
  return result.ec == std::errc() && result.ptr == last;
}

}  // namespace

void append_fixed(std::string& text, double value, int decimals) {
  if (!std::isfinite(value)) return;
  char buffer[400];  // the largest double has 309 digits before the point
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  assert(result.ec == std::errc());
  std::string_view digits(buffer, result.ptr - buffer);
  if (digits.front() == '-' && digits.find_first_not_of("-0.") == std::string_view::npos) {
    digits.remove_prefix(1);
  }
  text += digits;
}

void append_integer(std::string& text, long long value) {
  char buffer[24];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  text.append(buffer, result.ptr);
}

std::string system_reason(int error_number) {
  return error_number == 0 ? "unknown reason" : std::generic_category().message(error_number);
}

std::string read_text_file(const std::string& path, const std::string& kind) {
  std::error_code ignored;
  require(!std::filesystem::is_directory(path, ignored), path + ": is a folder, expected " + kind);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  require(file.is_open(), path + ": " + system_reason(errno) + ", expected " + kind);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  require(!file.bad(), path + ": cannot be read to its end, expected " + kind);
  return text;
}

CsvTable::CsvTable(const std::string& path,
                   const std::string& kind,
                   const std::vector<std::string>& required_names)
    : path_(path), text_(read_text_file(path, kind)) {
  std::string_view rest = text_;
  if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());

  std::vector<std::string_view> line_cells;
  for (int line_number = 1; !rest.empty(); ++line_number) {
    const auto end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (stripped(line).empty()) continue;
    line_cells.clear();
    split_cells(line, line_cells);
    if (names_.empty()) {
      set_names(line_cells, line_number, kind, required_names);
      continue;
    }
    require(line_cells.size() == names_.size(),
            path + ":" + std::to_string(line_number) + ": " + std::to_string(line_cells.size()) +
                " cells, expected " + std::to_string(names_.size()) +
                " as in the first line (decimal point, not comma)");
    cells_.insert(cells_.end(), line_cells.begin(), line_cells.end());
    line_numbers_.push_back(line_number);
  }
  require(!names_.empty(), path + ": is empty, expected " + kind);
  require(!line_numbers_.empty(), path + ": has no rows below its first line, expected " + kind);
}

int CsvTable::find(std::string_view name) const {
  for (int column = 0; column < num_columns(); ++column) {
    if (same_name(names_[column], name)) return column;
  }
  return -1;
}

void CsvTable::set_names(const std::vector<std::string_view>& names,
                         int line_number,
                         const std::string& kind,
                         const std::vector<std::string>& required_names) {
  const std::string place = path_ + ":" + std::to_string(line_number) + ": ";
  const std::string expected = ", expected " + kind;
  names_.assign(names.begin(), names.end());
  require(names_.size() > 1,
          place + quote_value(names.front()) + expected +
              " whose first line names the columns, separated by commas");
  std::string missing;
  for (const std::string& name : required_names) {
    required_.push_back(find(name));
    if (required_.back() < 0) missing += (missing.empty() ? "" : ", ") + name;
  }
  require(missing.empty(), place + "missing column " + missing + expected);
}

double CsvTable::number(int row, int column, double low, double high) const {
  double value = 0.0;
  const bool is_number = parse_whole(cell(row, column), value) && std::isfinite(value);
  if (!is_number || value < low || value > high) {
    std::string expected = "a number";
    if (std::isfinite(low) && std::isfinite(high)) {
      expected += " in [" + shortest_text(low) + ", " + shortest_text(high) + "]";
    } else if (std::isfinite(low)) {
      expected += " of at least " + shortest_text(low);
    }
    complain(row, column, expected);
  }
  return value;
}

int CsvTable::integer(int row, int column, int low, int high) const {
  int value = 0;
  if (!parse_whole(cell(row, column), value) || value < low || value > high) {
    const std::string range = low == high ? std::to_string(low)
                                          : "a whole number in [" + std::to_string(low) + ", " +
                                                std::to_string(high) + "]";
    complain(row, column, range);
  }
  return value;
}

void CsvTable::complain(int row, int column, const std::string& expected) const {
  const std::string value = empty(row, column) ? "empty cell" : quote_value(cell(row, column));
  throw InputError(path_ + ":" + std::to_string(line_numbers_[row]) + ": column " + names_[column] +
                   ": " + value + ", expected " + expected);
}

}  // namespace zygoma
