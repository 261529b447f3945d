#include "src/io/landmarks_file.h"

#include "src/base/check.h"
#include "src/io/text.h"

namespace zygoma {
namespace {

constexpr const char* kKind = "a landmarks CSV file as OpenFace writes it";
constexpr double kLeastConfidence = 0.5;
constexpr double kFarthest_px = 1e5;
constexpr int kLargestFrame = 100'000'000;

enum Column { kFrame, kTimestamp, kConfidence, kSuccess, kFirstX };
constexpr int kFirstY = kFirstX + static_cast<int>(kNumLandmarks);

std::vector<std::string> column_names() {
  std::vector<std::string> names{"frame", "timestamp", "confidence", "success"};
  for (const char* axis : {"x_", "y_"}) {
    for (size_t i = 0; i < kNumLandmarks; ++i) names.push_back(axis + std::to_string(i));
  }
  return names;
}

}  // namespace

LandmarkTrack read_landmarks_csv(const std::string& path) {
  const CsvTable table(path, kKind, column_names());
  const std::vector<int>& column = table.required();
  LandmarkTrack track;
  track.path = path;
  int first = 0;
  int last = -1;
  for (int row = 0; row < table.num_rows(); ++row) {
    const int number = table.integer(row, column[kFrame], 0, kLargestFrame);
    if (row == 0) first = number > 0 ? 1 : 0;
    const int frame = number - first;
    if (frame <= last) {
      table.complain(row, column[kFrame], "a later frame in every row (one face in the file)");
    }
    last = frame;
    table.number(row, column[kTimestamp], 0.0, 1e9);
    const bool success = table.integer(row, column[kSuccess], 0, 1) == 1;
    const double confidence = table.number(row, column[kConfidence], 0.0, 1.0);
    Landmarks landmarks;
    for (size_t i = 0; i < kNumLandmarks; ++i) {
      const int at = static_cast<int>(i);
      landmarks[i] = {table.number(row, column[kFirstX + at], -kFarthest_px, kFarthest_px),
                      table.number(row, column[kFirstY + at], -kFarthest_px, kFarthest_px)};
    }
    if (success && confidence >= kLeastConfidence) track.seen.emplace(frame, landmarks);
  }
  track.num_frames = last + 1;
  require(!track.seen.empty(),
          path + ": no frame has success 1 and a confidence of at least " +
              shortest_text(kLeastConfidence) + ", expected landmarks of a face");
  return track;
}

}  // namespace zygoma
