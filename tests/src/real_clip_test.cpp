// The whole chain on a real smile.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/io/video_reader.h"
#include "tests/src/program.h"
#include "tests/src/scratch_folder.h"
#include "tests/support/reference_track.h"
#include "tests/support/shared_folder.h"

namespace zygoma {
namespace {

int num_pictures(const std::string& video) {
  VideoReader reader(video);
  Frame frame;
  int count = 0;
  while (reader.read(frame)) ++count;
  return count;
}

// Where a point lies as the eyes see it: origin between them, x towards the subject's left eye, the
// distance of the eyes as unit.
Point2 in_eye_frame(const ReferencePoints& points, int index) {
  const Point2 right = mean_of(points, 36, 41);
  const Point2 left = mean_of(points, 42, 47);
  const Point2 x_axis = (left - right) / (left - right).squaredNorm();
  const Point2 y_axis(-x_axis.y(), x_axis.x());
  const Point2 d = points[index] - 0.5 * (left + right);
  return {d.dot(x_axis), d.dot(y_axis)};
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double mean_a = 0.0;
  double mean_b = 0.0;
  const auto n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / n;
    mean_b += b[i] / n;
  }
  double aa = 0.0;
  double bb = 0.0;
  double ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

void expect_in_range(const ContractionTrack& track) {
  for (const Contractions& frame : track.frames) {
    SCOPED_TRACE("frame " + std::to_string(frame.frame_index));
    ASSERT_EQ(frame.value.size(), track.muscles.size()) << "the face is there in all frames";
    for (std::size_t i = 0; i < frame.value.size(); ++i) {
      EXPECT_TRUE(frame.value[i] >= 0.0 && frame.value[i] <= 1.0)
          << track.muscles[i] << ' ' << frame.value[i];
    }
    for (const double sigma : frame.sigma) EXPECT_TRUE(sigma >= 0.0 && std::isfinite(sigma));
    EXPECT_TRUE(frame.jaw >= 0.0 && frame.jaw <= 1.0) << frame.jaw;
    EXPECT_TRUE(frame.confidence >= 0.0 && frame.confidence <= 1.0) << frame.confidence;
    EXPECT_TRUE(std::isfinite(frame.head.x_px) && std::isfinite(frame.head.y_px));
    EXPECT_TRUE(std::isfinite(frame.head.roll_rad) && frame.head.scale > 0.0);
    for (const auto& [contour, residual] : frame.residual_px) {
      EXPECT_TRUE(residual >= 0.0 && std::isfinite(residual)) << contour;
    }
  }
}

// Pearson's r of a muscle with the way the reference's corner of the mouth (point 48 or 54) goes
// outwards and up.
double follows_corner(const ContractionTrack& track,
                      const std::string& muscle,
                      const std::map<int, ReferencePoints>& reference,
                      int corner) {
  const auto column = std::find(track.muscles.begin(), track.muscles.end(), muscle);
  if (column == track.muscles.end()) return 0.0;
  const auto index = static_cast<std::size_t>(column - track.muscles.begin());
  const double outwards = corner == 54 ? 1.0 : -1.0;
  std::vector<double> contraction;
  std::vector<double> movement;
  for (const Contractions& frame : track.frames) {
    const auto points = reference.find(frame.frame_index);
    if (points == reference.end()) continue;
    const Point2 p = in_eye_frame(points->second, corner);
    contraction.push_back(frame.value[index]);
    movement.push_back(outwards * p.x() - p.y());  // y points down
  }
  EXPECT_GT(contraction.size(), track.frames.size() / 2);
  return correlation(contraction, movement);
}

TEST(RealClip, SmileIsFollowedByBothZygomatici) {
  const std::string clip = shared_folder() + "/video/smile.mp4";
  const std::string reference_path = shared_folder() + "/video/reference/smile.csv";
  if (!std::filesystem::exists(clip) || !std::filesystem::exists(reference_path)) {
    GTEST_SKIP() << clip << " or its reference is not there; ZYGOMA_SHARED names the folder";
  }
  const ScratchFolder folder;
  const Outcome outcome = run_program(folder, {"run", clip, "-o", folder / "out"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;

  const int num_frames = num_pictures(clip);
  const std::vector<ContourSet> contours = read_contours_csv(folder / "out/contours.csv");
  const ContractionTrack track = read_contractions_csv(folder / "out/contractions.csv");
  ASSERT_EQ(static_cast<int>(contours.size()), num_frames);
  ASSERT_EQ(static_cast<int>(track.frames.size()), num_frames);
  EXPECT_EQ(num_pictures(folder / "out/reconstruction.mp4"), num_frames);
  for (int i = 0; i < num_frames; ++i) {
    EXPECT_EQ(contours[i].frame_index, i);
    EXPECT_EQ(track.frames[i].frame_index, i);
    EXPECT_EQ(track.frames[i].time_s, contours[i].time_s);
    for (const Contour& contour : contours[i].contours) {
      for (const Point2& p : contour.points_px) EXPECT_TRUE(p.allFinite()) << contour.name;
    }
  }
  expect_in_range(track);

  const std::map<int, ReferencePoints> reference = read_reference(reference_path);
  const double left = follows_corner(track, "zygomaticus_major_L", reference, 54);
  const double right = follows_corner(track, "zygomaticus_major_R", reference, 48);
  RecordProperty("correlation_left", std::to_string(left));
  RecordProperty("correlation_right", std::to_string(right));
  EXPECT_GE(left, 0.7);
  EXPECT_GE(right, 0.7);
}

}  // namespace
}  // namespace zygoma
