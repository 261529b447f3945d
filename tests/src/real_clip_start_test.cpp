// Tracks of real faces that start in the middle of what the face does.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "src/io/video_reader.h"
#include "tests/support/lines.h"
#include "tests/support/reference_track.h"
#include "tests/support/shared_folder.h"
#include "tracker/robust.h"
#include "tracker/tracker.h"

namespace zygoma {
namespace {

constexpr int kStarts = 5;  // per clip

// Mean distance of both lips from the reference, of the distance of the eyes.
double lips_off(const ContourSet& set, const ReferencePoints& points) {
  const ReferencePoints upper(points.begin() + 48, points.begin() + 55);
  ReferencePoints lower(points.begin() + 54, points.begin() + 60);
  lower.push_back(points[48]);
  const double eyes_px = (mean_of(points, 42, 47) - mean_of(points, 36, 41)).norm();
  double sum_px = 0.0;
  double nodes = 0.0;
  for (const auto& [name, line] :
       std::map<std::string, ReferencePoints>{{"upper_lip", upper}, {"lower_lip", lower}}) {
    const Contour* lip = set.visible(name);
    if (lip == nullptr) return 1.0;
    for (const Point2& p : lip->points_px) sum_px += distance_to_line(p, line);
    nodes += static_cast<double>(lip->points_px.size());
  }
  return sum_px / nodes / eyes_px;
}

TEST(RealClip, TheMouthIsFoundWhateverItDoesAtTheStart) {
  std::vector<double> off;
  for (const char* name : {"smile.mp4",
                           "wide_smile.mp4",
                           "brows_woman.mp4",
                           "speech_lbax4n.mpg",
                           "speech_lrwp9a.mpg",
                           "speech_sbia1a.mpg"}) {
    const std::filesystem::path clip = shared_folder() + "/video/" + name;
    const std::filesystem::path track =
        clip.parent_path() / "reference" / (clip.stem().string() + ".csv");
    if (!std::filesystem::exists(clip) || !std::filesystem::exists(track)) {
      GTEST_SKIP() << clip << " or its reference is not there; ZYGOMA_SHARED names the folder";
    }
    const std::map<int, ReferencePoints> reference = read_reference(track.string());
    const int step = std::max(1, reference.rbegin()->first / kStarts);
    VideoReader reader(clip.string());
    for (Frame frame; reader.read(frame);) {
      const auto points = reference.find(frame.index);
      if (frame.index % step != 0 || points == reference.end()) continue;
      off.push_back(lips_off(Tracker().track(frame), points->second));
      EXPECT_LT(off.back(), 0.08) << name << ", picture " << frame.index;
    }
  }
  RecordProperty("median", std::to_string(median(off)));
  EXPECT_LT(median(off), 0.025);
}

}  // namespace
}  // namespace zygoma
