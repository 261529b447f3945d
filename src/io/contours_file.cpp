#include "src/io/contours_file.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "src/base/names.h"
#include "src/io/atomic_file.h"
#include "src/io/text.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

constexpr const char* kKind = "a contours CSV file";
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A visible contour never rounds to confidence 0, which means lost.
constexpr double kSmallestWrittenConfidence = 1e-4;

enum Column { kFrame, kTimestamp, kContour, kNode, kX, kY, kConfidence, kLocked };

const std::vector<std::string> kColumns{
    "frame", "timestamp", "contour", "node", "x", "y", "confidence", "locked"};

void append_contour(std::string& text, const ContourSet& set, const Contour& contour) {
  const auto begin_row = [&] {
    append_integer(text, set.frame_index);
    text += ',';
    append_fixed(text, set.time_s, 6);
    text += ',';
    text += contour.name;
    text += ',';
  };
  const char* locked = contour.locked ? ",1\n" : ",0\n";
  if (contour.lost()) {
    begin_row();
    text += ",,,";
    append_fixed(text, 0.0, 4);
    text += locked;
    return;
  }
  const double confidence = std::max(contour.confidence, kSmallestWrittenConfidence);
  for (std::size_t node = 0; node < contour.points_px.size(); ++node) {
    begin_row();
    append_integer(text, static_cast<long long>(node));
    text += ',';
    append_fixed(text, contour.points_px[node].x(), 4);
    text += ',';
    append_fixed(text, contour.points_px[node].y(), 4);
    text += ',';
    append_fixed(text, confidence, 4);
    text += locked;
  }
}

std::vector<Contour> lost_contours() {
  std::vector<Contour> contours;
  for (const Feature& feature : kFeatureSchema) {
    contours.push_back({std::string(feature.name), {}, 0.0, false});
  }
  return contours;
}

class ContoursReader {
 public:
  explicit ContoursReader(const std::string& path)
      : table_(path, kKind, kColumns), columns_(table_.required()) {}

  std::vector<ContourSet> read() {
    for (int row = 0; row < table_.num_rows(); ++row) {
      read_frame(row);
      read_node(row, contour_of(row));
    }
    return std::move(sets_);
  }

 private:
  // Opens a new set when the row belongs to the next frame.
  void read_frame(int row) {
    const int last = sets_.empty() ? -1 : sets_.back().frame_index;
    const int frame = table_.integer(row, columns_[kFrame], std::max(last, 0), last + 1);
    const double time_s = table_.number(row, columns_[kTimestamp], -kInfinity, kInfinity);
    if (frame == last) {
      if (time_s != sets_.back().time_s) {
        table_.complain(row, columns_[kTimestamp], "the same as in the frame's rows above");
      }
      return;
    }
    if (!sets_.empty() && time_s <= sets_.back().time_s) {
      table_.complain(row, columns_[kTimestamp], "a later time than in the frame before");
    }
    sets_.push_back({frame, time_s, lost_contours()});
    seen_.assign(kFeatureSchema.size(), false);
  }

  Contour& contour_of(int row) {
    const std::string_view name = table_.cell(row, columns_[kContour]);
    const int place = find_name(kFeatureSchema, name);
    if (place >= 0) return current(row, place);
    table_.complain(row, columns_[kContour], "one of " + joined_names(kFeatureSchema));
  }

  // A contour that was said to be lost, or is given point by point, cannot become lost later.
  Contour& current(int row, std::size_t i) {
    Contour& contour = sets_.back().contours[i];
    const bool lost_row = table_.empty(row, columns_[kNode]);
    if (seen_[i] && (lost_row || contour.lost())) {
      table_.complain(row, columns_[kNode], "either one row without a node or numbered nodes");
    }
    seen_[i] = true;
    return contour;
  }

  void read_node(int row, Contour& contour) const {
    contour.locked = table_.integer(row, columns_[kLocked], 0, 1) == 1;
    const double confidence = table_.number(row, columns_[kConfidence], 0.0, 1.0);
    if (table_.empty(row, columns_[kNode])) {
      for (const Column column : {kX, kY}) {
        if (!table_.empty(row, columns_[column])) {
          table_.complain(row, columns_[column], "an empty cell, as the node is empty");
        }
      }
      if (confidence != 0.0) table_.complain(row, columns_[kConfidence], "0 for a lost contour");
      return;
    }
    if (confidence == 0.0) {
      table_.complain(row, columns_[kConfidence], "more than 0 for a contour that has nodes");
    }
    const int next = static_cast<int>(contour.points_px.size());
    table_.integer(row, columns_[kNode], next, next);
    contour.points_px.emplace_back(table_.number(row, columns_[kX], -kInfinity, kInfinity),
                                   table_.number(row, columns_[kY], -kInfinity, kInfinity));
    contour.confidence = confidence;
  }

  CsvTable table_;
  std::vector<int> columns_;
  std::vector<ContourSet> sets_;
  std::vector<bool> seen_;
};

}  // namespace

void write_contours_csv(const std::string& path, const std::vector<ContourSet>& contours) {
  AtomicFile file(path);
  std::string text;
  for (const std::string& name : kColumns) text += (text.empty() ? "" : ",") + name;
  text += '\n';
  const std::vector<Contour> none = lost_contours();
  for (const ContourSet& set : contours) {
    for (const Contour& contour : set.contours.empty() ? none : set.contours) {
      append_contour(text, set, contour);
    }
    file.stream() << text;
    text.clear();
  }
  file.stream() << text;
  file.commit();
}

std::vector<ContourSet> read_contours_csv(const std::string& path) {
  return ContoursReader(path).read();
}

}  // namespace zygoma
