// Hard cases of corrections by hand: a spring pulled and released, a contour dragged across a
// ridge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/hard/record.h"
#include "tests/support/two_bands.h"

namespace zygoma::hard {
namespace {

double furthest(const Contour& a, const Contour& b) {
  double far = 0.0;
  for (size_t i = 0; i < a.points_px.size(); ++i) {
    far = std::max(far, (a.points_px[i] - b.points_px[i]).norm());
  }
  return far;
}

TEST(HC74, APulledContourComesBack) {
  // Left alone for as long, the contour settles in the minimum of its own.
  const std::vector<ContourSet> alone = corrected({pull(kBrowRow)});
  const std::vector<ContourSet> pulled = corrected({pull(kBrowRow - 2.5)});
  const std::vector<ContourSet> automatic = automatic_track();
  const double pulled_by = middle_row(alone[kCorrected]) - middle_row(pulled[kCorrected]);
  EXPECT_GT(pulled_by, 1.5);
  double off = 0.0;
  int touched = 0;
  for (int k = 0; k < kNumFrames; ++k) {
    touched += k != kCorrected && pulled[k] != automatic[k] ? 1 : 0;
    if (std::abs(k - kCorrected) < 8) continue;
    off = std::max(off, furthest(pulled[k].contours[kBrowLeft], automatic[k].contours[kBrowLeft]));
  }
  EXPECT_EQ(off, 0.0);
  EXPECT_LT(touched, 14);
  record("a spring pulls the brow by " + figure(pulled_by) + " px off its edge in one frame",
         "back on the automatic track to the bit after at most " +
             std::to_string((touched + 1) / 2) + " frames",
         "same minimum, < 0.05 px");
}

TEST(HC75, DraggedAcrossARidgeAContourStaysThere) {
  const std::vector<ContourSet> track = corrected({pull(kOtherRow)});
  double off = 0.0;
  for (const ContourSet& set : track) off = std::max(off, std::abs(middle_row(set) - kOtherRow));
  EXPECT_LT(off, 1.5);
  EXPECT_EQ(track, corrected({pull(kOtherRow)}));
  record("the brow is dragged to another edge 12 px below, 40 frames",
         "within " + figure(off) + " px of that edge in every frame; replayed: same bits",
         "settles in the new minimum and stays; replay gives the same bits");
}

}  // namespace
}  // namespace zygoma::hard
