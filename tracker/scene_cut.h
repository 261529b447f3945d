// Notices a cut: a picture that has little in common with the one before it as a whole. Two heads
// framed alike are followed from one to the other by flow without a jump; the walls behind them,
// the clothes and the hair tell.
//
// The pictures are compared very small and divided by their mean, so that motion and exposure
// hardly count: the mean difference is a few thousandths from frame to frame and tenths at a cut.
// What is usual is remembered, as a shaken camera changes more. Black pictures are left out: what
// was there may come back.
#pragma once

#include <opencv2/core.hpp>

#include "tracker/picture.h"

namespace zygoma {

class SceneCut {
 public:
  // Takes the next picture.
  bool at(const Picture& picture);

 private:
  cv::Mat last_;
  double usual_ = 0.0;  // difference from frame to frame, running mean
};

}  // namespace zygoma
