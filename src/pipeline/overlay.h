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

// One row per muscle pair (left and right bars) and one for the jaw, filling `bgr`.
void draw_contraction_bars(const std::vector<std::string>& muscles,
                           const Contractions& contractions,
                           cv::Mat& bgr);

}  // namespace zygoma
