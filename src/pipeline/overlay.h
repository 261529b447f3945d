// Draws contours over a picture, coloured by confidence (green: sure, yellow: doubtful, red: hardly
// anything), and contraction bars.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "face/contractions.h"
#include "tracker/contour_set.h"

namespace zygoma {

// `scale` maps contour pixels to pixels of `bgr`.
void draw_contours(const ContourSet& contours, double scale, cv::Mat& bgr);

// A panel with one row per muscle pair (left and right bars) and one for the jaw. The labels are
// drawn once.
class ContractionBars {
 public:
  ContractionBars(const std::vector<std::string>& muscles, cv::Size size_px);

  // Fills `bgr`, of the size given; values in the order of the muscles.
  void draw(const Contractions& contractions, cv::Mat& bgr) const;

 private:
  struct Bar {
    cv::Rect box;
    int muscle = -1;  // -1: the jaw
  };
  std::size_t num_muscles_ = 0;
  std::vector<Bar> bars_;
  cv::Mat background_;
};

}  // namespace zygoma
