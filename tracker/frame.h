// One decoded picture with its place in time. Pixels as shown (rotation tag applied), origin at the
// centre of the top-left pixel, x right, y down.
#pragma once

#include <opencv2/core.hpp>

namespace zygoma {

struct Frame {
  int index = 0;        // of the decoded frame, from 0, no gaps
  double time_s = 0.0;  // container time stamp, seconds from the first frame
  cv::Mat image;        // 8-bit BGR
};

}  // namespace zygoma
