// A frame as the tracker looks at it: turned to the way round that its mirror says (mirror.h), and
// as BGR only where it is looked at. Most of a picture is never asked for, so it is never
// converted, copied or turned.
//
// Planes become colours as in BT.601, whatever matrix they were made with: what skin and lips look
// like is learned from each face.
#pragma once

#include <opencv2/core.hpp>

#include "tracker/frame.h"

namespace zygoma {

// Any 8-bit picture of 1, 3 or 4 channels as BGR; empty if it is none.
cv::Mat as_bgr(const cv::Mat& image);

class Picture {
 public:
  Picture(const cv::Mat& image) : Picture(Frame{0, 0.0, image}) {}  // not explicit: it is one
  // Shares the frame's pixels. Empty if it has none of 8 bits.
  explicit Picture(const Frame& frame, bool turned = false);

  cv::Size size() const { return size_; }
  bool empty() const { return size_.empty(); }

  // A part of it (inside it), 8-bit BGR, and its brightness.
  cv::Mat bgr(const cv::Rect& box) const;
  cv::Mat grey(const cv::Rect& box) const;
  cv::Mat bgr() const { return bgr({{}, size_}); }
  // The whole picture from a few of its pixels. Even size.
  cv::Mat sparse(const cv::Size& size) const;

 private:
  cv::Rect stored(const cv::Rect& box) const;
  cv::Mat turned(const cv::Mat& part) const;

  cv::Mat image_;
  Planes planes_;
  cv::Size size_;
  bool turned_ = false;
};

}  // namespace zygoma
