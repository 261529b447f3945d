// Written by the fit of tests/hard/tracker_confidence_test.cpp: where the nodes of the tracker's
// contours stand against those of the face model, chart px, of the subject's left side.
#pragma once

#include <array>
#include <string_view>

namespace zygoma::hard {

struct NodeOffset {
  std::string_view kind;  // the name of the contour, less its side
  double x_px;
  double y_px;
};

inline constexpr std::array<NodeOffset, 84> kNodeOffsets{{
    {"brow", 6.60, -3.52},       {"brow", 5.14, -1.19},       {"brow", 3.58, 0.56},
    {"brow", 1.28, 0.89},        {"brow", -1.03, 0.36},       {"brow", -3.10, 0.73},
    {"brow", -5.02, -1.18},      {"brow", -5.24, -3.91},      {"brow", -6.12, -5.76},
    {"chin_boss", 0.12, 0.53},   {"chin_boss", 0.22, -0.25},  {"chin_boss", 0.08, -0.37},
    {"chin_boss", 0.00, -0.96},  {"chin_boss", -0.13, -1.11}, {"chin_boss", -0.29, -0.90},
    {"chin_boss", -0.35, -0.25}, {"chin_boss", -0.48, -0.10}, {"chin_boss", -0.35, 0.72},
    {"eyelid", -0.56, -2.76},    {"eyelid", 0.89, -2.22},     {"eyelid", 1.09, -1.89},
    {"eyelid", 0.67, -1.72},     {"eyelid", -0.07, -1.69},    {"eyelid", -0.85, -1.88},
    {"eyelid", -1.40, -2.28},    {"eyelid", -1.58, -2.76},    {"eyelid", -0.82, -3.55},
    {"furrow", -0.84, -2.30},    {"furrow", -0.80, -1.63},    {"furrow", -0.63, -1.49},
    {"furrow", -0.86, -1.17},    {"furrow", -1.12, -0.94},    {"furrow", -1.25, -0.66},
    {"furrow", -1.11, -0.70},    {"furrow", -0.65, -0.82},    {"furrow", 0.11, -1.04},
    {"hairline", 5.29, -4.50},   {"hairline", 4.51, -3.04},   {"hairline", 4.22, -1.10},
    {"hairline", 3.21, -1.77},   {"hairline", 2.19, -2.34},   {"hairline", 1.13, -2.35},
    {"hairline", -0.06, -2.42},  {"hairline", -0.93, -2.38},  {"hairline", -1.95, -2.36},
    {"hairline", -2.75, -1.73},  {"hairline", -3.81, -1.07},  {"hairline", -4.00, -3.03},
    {"hairline", -4.59, -4.40},  {"lower_lip", -0.63, -1.68}, {"lower_lip", -0.53, -1.19},
    {"lower_lip", -0.61, -0.58}, {"lower_lip", -0.37, -0.47}, {"lower_lip", -0.39, -0.03},
    {"lower_lip", -0.27, 0.25},  {"lower_lip", -0.11, 0.42},  {"lower_lip", 0.05, 0.21},
    {"lower_lip", 0.14, -0.03},  {"lower_lip", 0.14, -0.41},  {"lower_lip", 0.39, -0.51},
    {"lower_lip", 0.29, -1.14},  {"lower_lip", 0.26, -1.73},  {"nose_tip", 7.80, 2.93},
    {"nose_tip", 5.99, 1.96},    {"nose_tip", 4.09, 1.25},    {"nose_tip", 2.08, 1.14},
    {"nose_tip", 0.07, 0.59},    {"nose_tip", -1.99, 1.09},   {"nose_tip", -4.01, 1.25},
    {"nose_tip", -5.94, 1.98},   {"nose_tip", -7.78, 3.04},   {"upper_lip", -0.63, -1.68},
    {"upper_lip", 0.09, -0.41},  {"upper_lip", 0.43, 0.72},   {"upper_lip", 0.06, 0.71},
    {"upper_lip", -0.18, 1.10},  {"upper_lip", -0.19, 1.90},  {"upper_lip", -0.14, 0.80},
    {"upper_lip", -0.08, 1.94},  {"upper_lip", -0.15, 1.07},  {"upper_lip", -0.43, 0.65},
    {"upper_lip", -0.79, 0.67},  {"upper_lip", -0.50, -0.47}, {"upper_lip", 0.26, -1.73},
}};

}  // namespace zygoma::hard
