// Numbers and tables as text, the same bytes whatever the locale: the parts the CSV files share.
//
// Reading is forgiving about what editors and spreadsheets do to a file (byte-order mark, CRLF,
// blanks around cells, upper case in names, empty lines, order of columns, extra columns) and
// strict about values. Every complaint names file, line, column, value and what was expected.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace zygoma {

// Appends `value` with a fixed number of decimals; nothing (an empty cell) if it is not finite.
// A value that rounds to zero has no sign.
void append_fixed(std::string& text, double value, int decimals);
void append_integer(std::string& text, long long value);

// The whole file. Throws InputError naming it when it is missing, a folder or unreadable.
// `kind` says what was expected ("a contractions CSV file").
std::string read_text_file(const std::string& path, const std::string& kind);

// The reason behind errno, as text.
std::string system_reason(int error_number);

class CsvTable {
 public:
  // Throws InputError unless there are a header with the names required, at least one row, and as
  // many cells in every row as names in the header.
  CsvTable(const std::string& path,
           const std::string& kind,
           const std::vector<std::string>& required_names);

  int num_rows() const { return static_cast<int>(line_numbers_.size()); }
  int num_columns() const { return static_cast<int>(names_.size()); }
  const std::string& name(int column) const { return names_[column]; }  // as written in the file

  // The column of that name (case-insensitive), or -1.
  int find(std::string_view name) const;
  // The columns of the required names, in that order.
  const std::vector<int>& required() const { return required_; }

  std::string_view cell(int row, int column) const { return cells_[row * names_.size() + column]; }
  bool empty(int row, int column) const { return cell(row, column).empty(); }

  // The value of a cell. Throws InputError unless it is a finite number in [low, high].
  double number(int row, int column, double low, double high) const;
  int integer(int row, int column, int low, int high) const;

  // InputError about a cell: "FILE:LINE: column NAME: VALUE, expected WHAT".
  [[noreturn]] void complain(int row, int column, const std::string& expected) const;

 private:
  void set_names(const std::vector<std::string_view>& names,
                 int line_number,
                 const std::string& kind,
                 const std::vector<std::string>& required_names);

  std::string path_;
  std::string text_;
  std::vector<std::string> names_;
  std::vector<int> required_;
  std::vector<std::string_view> cells_;  // into text_, row by row
  std::vector<int> line_numbers_;
};

}  // namespace zygoma
