#include "src/io/contractions_file.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "face/muscle.h"
#include "src/base/check.h"
#include "src/io/atomic_file.h"
#include "src/io/text.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

constexpr const char* kKind = "a contractions CSV file";
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kSigmaSuffix = "_sigma";
constexpr std::string_view kResidualPrefix = "resid_px_";
constexpr std::string_view kObservedSuffix = "_observed";

// The columns before the muscles; jaw_sigma follows them.
enum Column {
  kFrame,
  kTimestamp,
  kConfidence,
  kSuccess,
  kHeadX,
  kHeadY,
  kHeadScale,
  kHeadRoll,
  kJaw
};

const std::vector<std::string> kColumns{"frame",
                                        "timestamp",
                                        "confidence",
                                        "success",
                                        "head_x",
                                        "head_y",
                                        "head_scale",
                                        "head_roll",
                                        "jaw"};

// Muscles of one group (both sides of NAME, or NAME alone) as indices into the track's list.
std::vector<std::vector<int>> groups_of(const std::vector<std::string>& muscles) {
  std::vector<std::vector<int>> groups;
  for (int i = 0; i < static_cast<int>(muscles.size()); ++i) {
    const std::string_view base = without_side(muscles[i]);
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& indices) {
      return without_side(muscles[indices.front()]) == base;
    });
    if (group == groups.end()) {
      groups.push_back({i});
    } else {
      group->push_back(i);
    }
  }
  return groups;
}

std::string header_of(const std::vector<std::string>& muscles,
                      const std::vector<std::vector<int>>& groups,
                      bool flags) {
  std::string text;
  for (const std::string& name : kColumns) text += name + ',';
  text += "jaw_sigma";
  for (const std::vector<int>& group : groups) {
    for (const int i : group) text += ',' + muscles[i];
    for (const int i : group) text.append(",").append(muscles[i]).append(kSigmaSuffix);
  }
  for (const Feature& feature : kContours1992) {
    text.append(",").append(kResidualPrefix).append(feature.name);
  }
  if (!flags) return text + '\n';
  text.append(",jaw").append(kObservedSuffix);
  for (const std::vector<int>& group : groups) {
    for (const int i : group) text.append(",").append(muscles[i]).append(kObservedSuffix);
  }
  return text + '\n';
}

void append_cell(std::string& text, std::optional<double> value, int decimals) {
  text += ',';
  if (value) append_fixed(text, *value, decimals);
}

std::optional<double> residual_of(const Contractions& frame, std::string_view contour) {
  for (const auto& [name, value] : frame.residual_px) {
    if (name == contour) return value;
  }
  return std::nullopt;
}

// A frame that could not be estimated has empty cells where it has nothing to say.
void append_row(std::string& text,
                const Contractions& frame,
                const std::vector<std::string>& muscles,
                const std::vector<std::vector<int>>& groups,
                bool flags) {
  const bool estimated = frame.value.size() == muscles.size();
  assert(estimated || frame.value.empty());
  assert(frame.sigma.empty() || frame.sigma.size() == frame.value.size());

  append_integer(text, frame.frame_index);
  append_cell(text, frame.time_s, 6);
  append_cell(text, frame.confidence, 4);
  text += frame.success ? ",1" : ",0";

  const bool has_head = estimated || frame.head != HeadPose{};
  const auto if_head = [&](double value) { return has_head ? std::optional(value) : std::nullopt; };
  append_cell(text, if_head(frame.head.x_px), 4);
  append_cell(text, if_head(frame.head.y_px), 4);
  append_cell(text, if_head(frame.head.scale), 6);
  append_cell(text, if_head(frame.head.roll_rad), 6);

  const bool has_jaw = estimated || frame.jaw != 0.0 || frame.jaw_sigma != 0.0;
  append_cell(text, has_jaw ? std::optional(frame.jaw) : std::nullopt, 6);
  append_cell(text, has_jaw ? std::optional(frame.jaw_sigma) : std::nullopt, 6);

  const auto at = [](const std::vector<double>& values, int i) {
    return values.empty() ? std::nullopt : std::optional(values[i]);
  };
  for (const std::vector<int>& group : groups) {
    for (const int i : group) append_cell(text, at(frame.value, i), 6);
    for (const int i : group) append_cell(text, at(frame.sigma, i), 6);
  }
  for (const Feature& feature : kContours1992) {
    append_cell(text, residual_of(frame, feature.name), 4);
  }
  const auto flag = [&](bool value) {
    append_cell(text, frame.observed.empty() ? std::nullopt : std::optional(value ? 1.0 : 0.0), 0);
  };
  if (flags) flag(frame.jaw_observed);
  for (std::size_t g = 0; flags && g < groups.size(); ++g) {
    for (const int i : groups[g]) flag(!frame.observed.empty() && frame.observed[i]);
  }
  text += '\n';
}

class ContractionsReader {
 public:
  explicit ContractionsReader(const std::string& path)
      : path_(path), table_(path, kKind, kColumns), columns_(table_.required()) {
    jaw_sigma_column_ = table_.find("jaw_sigma");
    find_muscles();
    find_observed();
    for (const Feature& feature : kContours1992) {
      const int column = table_.find(std::string(kResidualPrefix) + std::string(feature.name));
      if (column >= 0) residual_columns_.emplace_back(feature.name, column);
    }
  }

  ContractionTrack read() {
    for (int row = 0; row < table_.num_rows(); ++row) {
      Contractions frame;
      read_place(row, frame);
      read_head_and_jaw(row, frame);
      read_muscles(row, frame);
      read_observed(row, frame);
      for (const auto& [name, column] : residual_columns_) {
        if (table_.empty(row, column)) continue;
        frame.residual_px.emplace_back(name, table_.number(row, column, 0.0, kInfinity));
      }
      track_.frames.push_back(std::move(frame));
    }
    return std::move(track_);
  }

 private:
  // A muscle is a column with a side, or one that has a column of its own for sigma.
  void find_muscles() {
    for (int column = 0; column < table_.num_columns(); ++column) {
      const std::string& name = table_.name(column);
      if (name.ends_with(kSigmaSuffix)) continue;
      const int sigma_column = table_.find(name + std::string(kSigmaSuffix));
      const bool is_known = std::find(columns_.begin(), columns_.end(), column) != columns_.end();
      if (is_known || (!has_side(name) && sigma_column < 0)) continue;
      require(table_.find(name) == column, path_ + ":1: column " + name + " is there twice");
      track_.muscles.push_back(name);
      value_columns_.push_back(column);
      sigma_columns_.push_back(sigma_column);
    }
    require(!track_.muscles.empty(),
            path_ + ":1: has no muscle, expected columns like zygomaticus_major_L");
    for (const std::string& name : track_.muscles) {
      if (has_side(name)) need_other_side(name);
    }
  }

  void find_observed() {
    jaw_observed_column_ = table_.find("jaw" + std::string(kObservedSuffix));
    for (const std::string& name : track_.muscles) {
      observed_columns_.push_back(table_.find(name + std::string(kObservedSuffix)));
    }
  }

  // Read where the file has a flag for every muscle of the row.
  void read_observed(int row, Contractions& frame) const {
    for (const int column : observed_columns_) {
      if (column < 0 || table_.empty(row, column)) return;
    }
    for (const int column : observed_columns_) {
      frame.observed.push_back(table_.integer(row, column, 0, 1) == 1);
    }
    frame.jaw_observed = jaw_observed_column_ >= 0 && !table_.empty(row, jaw_observed_column_) &&
                         table_.integer(row, jaw_observed_column_, 0, 1) == 1;
  }

  void need_other_side(const std::string& name) const {
    const std::string other =
        std::string(without_side(name)) + (name.ends_with("_L") ? "_R" : "_L");
    require(table_.find(other) >= 0,
            path_ + ":1: missing column " + other + ", as there is " + name);
  }

  void read_place(int row, Contractions& frame) const {
    frame.frame_index = table_.integer(row, columns_[kFrame], row, row);  // from 0, no gaps
    frame.time_s = table_.number(row, columns_[kTimestamp], -kInfinity, kInfinity);
    if (row > 0 && frame.time_s <= track_.frames.back().time_s) {
      table_.complain(row, columns_[kTimestamp], "a later time than in the row before");
    }
    frame.confidence = table_.number(row, columns_[kConfidence], 0.0, 1.0);
    frame.success = table_.integer(row, columns_[kSuccess], 0, 1) == 1;
  }

  // `fallback` for an empty cell, which only a frame without estimate may have.
  double number_or(int row, int column, double low, double high, double fallback) const {
    return table_.empty(row, column) ? fallback : table_.number(row, column, low, high);
  }

  void read_head_and_jaw(int row, Contractions& frame) const {
    constexpr double kSmallestScale = 1e-6;  // what six decimals can say
    const HeadPose none;
    frame.head.x_px = number_or(row, columns_[kHeadX], -kInfinity, kInfinity, none.x_px);
    frame.head.y_px = number_or(row, columns_[kHeadY], -kInfinity, kInfinity, none.y_px);
    frame.head.scale = number_or(row, columns_[kHeadScale], kSmallestScale, kInfinity, none.scale);
    frame.head.roll_rad = number_or(row, columns_[kHeadRoll], -kInfinity, kInfinity, none.roll_rad);
    frame.jaw = number_or(row, columns_[kJaw], 0.0, 1.0, 0.0);
    if (jaw_sigma_column_ >= 0) {
      frame.jaw_sigma = number_or(row, jaw_sigma_column_, 0.0, kInfinity, 0.0);
    }
  }

  void read_muscles(int row, Contractions& frame) const {
    const bool estimated = !table_.empty(row, value_columns_.front());
    frame.value = all_or_none(row, value_columns_, estimated, 1.0);
    if (estimated) {
      for (const Column column : {kHeadX, kHeadY, kHeadScale, kHeadRoll, kJaw}) {
        if (table_.empty(row, columns_[column])) {
          table_.complain(row, columns_[column], "a number, as the frame has contractions");
        }
      }
    }
    const int first_sigma = sigma_columns_.front();
    const bool has_sigma = first_sigma >= 0 && !table_.empty(row, first_sigma);
    frame.sigma = all_or_none(row, sigma_columns_, has_sigma, kInfinity);
    if (has_sigma && !estimated) {
      table_.complain(row, first_sigma, "an empty cell, as the frame has no contractions");
    }
  }

  // One value per column, or no value at all: a frame is estimated as a whole.
  std::vector<double> all_or_none(int row,
                                  const std::vector<int>& columns,
                                  bool all,
                                  double high) const {
    std::vector<double> values;
    for (const int column : columns) {
      const bool is_empty = column < 0 || table_.empty(row, column);
      if (all && column < 0)
        table_.complain(row, columns.front(), "a sigma column for every muscle");
      if (all) values.push_back(table_.number(row, column, 0.0, high));
      if (!all && !is_empty) {
        table_.complain(row, column, "an empty cell, as in the first column of its kind");
      }
    }
    return values;
  }

  std::string path_;
  CsvTable table_;
  std::vector<int> columns_;
  ContractionTrack track_;
  int jaw_sigma_column_ = -1;
  std::vector<int> value_columns_;
  std::vector<int> sigma_columns_;
  int jaw_observed_column_ = -1;
  std::vector<int> observed_columns_;
  std::vector<std::pair<std::string, int>> residual_columns_;
};

}  // namespace

void write_contractions_csv(const std::string& path, const ContractionTrack& track) {
  AtomicFile file(path);
  const std::vector<std::vector<int>> groups = groups_of(track.muscles);
  // Only estimates know what they saw.
  const bool flags = std::any_of(track.frames.begin(), track.frames.end(), [](const auto& frame) {
    return !frame.observed.empty();
  });
  std::string text = header_of(track.muscles, groups, flags);
  for (const Contractions& frame : track.frames) {
    append_row(text, frame, track.muscles, groups, flags);
  }
  file.stream() << text;
  file.commit();
}

ContractionTrack read_contractions_csv(const std::string& path) {
  return ContractionsReader(path).read();
}

}  // namespace zygoma
