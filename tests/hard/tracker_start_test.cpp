// A track may start on any expression, and without colour.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/hard/record.h"
#include "tests/hard/tracker_clips.h"
#include "tracker/robust.h"

namespace zygoma::hard {
namespace {

// The lips of tracks that start at every tenth picture, chart px off the truth.
std::vector<double> lips_at_start(const Clip& clip, const PictureChange& change) {
  std::vector<double> off_px;
  for (size_t i = 0; i < clip.frames.size(); i += 10) {
    const Track out = track(changed(part_of(clip, i, 1).frames, change));
    for (const char* lip : {"upper_lip", "lower_lip"}) {
      const Contour* seen = out.sets.front().visible(lip);
      const Contour* truth = clip.truth[i].visible(lip);
      EXPECT_TRUE(seen != nullptr && truth != nullptr) << lip << ", picture " << i;
      if (seen != nullptr && truth != nullptr) {
        off_px.push_back(distance(*seen, *truth, clip.chart_px));
      }
    }
  }
  return off_px;
}

TEST(Start, FindsTheMouthWithoutColour) {
  std::vector<double> off_px = lips_at_start(usual_performer(), [](size_t, const cv::Mat& picture) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return grey;
  });
  ASSERT_FALSE(off_px.empty());
  RecordProperty("median_px", figure(median(off_px)));
  RecordProperty("worst_px", figure(*std::max_element(off_px.begin(), off_px.end())));
  EXPECT_LT(median(off_px), 3.0);
  EXPECT_LT(*std::max_element(off_px.begin(), off_px.end()), 10.0);
}

}  // namespace
}  // namespace zygoma::hard
