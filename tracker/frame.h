// A decoded picture with its place in time. Pixels as shown (rotation tag applied), origin at the
// centre of the top-left pixel, x right, y down.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

namespace zygoma {

// A picture as most video stores it: Y and, at half its columns and rows, Cb and Cr; 8-bit, of even
// size, in video range (Y 16 to 235).
struct Planes {
  cv::Mat y, cb, cr;
  std::shared_ptr<const void> owner = {};  // of the pixels
};

struct Frame {
  int index = 0;        // of the decoded frame, from 0, no gaps
  double time_s = 0.0;  // container time stamp, seconds from the first frame
  cv::Mat image;        // 8-bit BGR; empty where there are planes instead
  Planes planes = {};
};

}  // namespace zygoma
