// What is drawn over pictures: contours coloured by confidence, and contraction bars.
//
// The colours run from dark violet (hardly anything) over green to yellow (sure): viridis, whose
// steps look equally large, which keeps its order in grey, and which the colour-blind can read.
// A rim, dark around bright lines and bright around dark ones, sets them off from skin and hair.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "face/contractions.h"
#include "tracker/head_frame.h"

namespace zygoma {

// BGR of a confidence in [0, 1].
cv::Scalar confidence_colour(double confidence);

struct ContourStyle {
  int width_px = 1;
  bool nodes = false;  // a dot on each, to see whether they slide along
};

// `canvas_from_image` maps contour pixels to pixels of `bgr`.
void draw_contours(const ContourSet& contours,
                   const Similarity& canvas_from_image,
                   const ContourStyle& style,
                   cv::Mat& bgr);

// The picture enlarged by `scale`: pixel centres stay centres.
Similarity enlargement(double scale);

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
