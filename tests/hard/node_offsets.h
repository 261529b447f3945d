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
    {"brow", 6.56, -3.56},       {"brow", 5.13, -1.17},       {"brow", 3.59, 0.56},
    {"brow", 1.34, 0.87},        {"brow", -0.94, 0.35},       {"brow", -2.97, 0.74},
    {"brow", -4.86, -1.15},      {"brow", -5.07, -3.87},      {"brow", -5.91, -5.66},
    {"chin_boss", 0.43, 0.77},   {"chin_boss", 0.48, -0.03},  {"chin_boss", 0.25, -0.13},
    {"chin_boss", 0.20, -0.73},  {"chin_boss", 0.08, -0.89},  {"chin_boss", -0.10, -0.70},
    {"chin_boss", -0.17, -0.07}, {"chin_boss", -0.28, 0.04},  {"chin_boss", -0.10, 0.85},
    {"eyelid", -0.73, -2.72},    {"eyelid", 0.77, -2.19},     {"eyelid", 1.01, -1.89},
    {"eyelid", 0.59, -1.71},     {"eyelid", -0.20, -1.68},    {"eyelid", -0.97, -1.87},
    {"eyelid", -1.53, -2.28},    {"eyelid", -1.68, -2.79},    {"eyelid", -0.91, -3.59},
    {"furrow", -0.88, -2.23},    {"furrow", -0.84, -1.48},    {"furrow", -0.65, -1.33},
    {"furrow", -0.92, -1.09},    {"furrow", -1.19, -0.90},    {"furrow", -1.32, -0.53},
    {"furrow", -1.22, -0.49},    {"furrow", -0.82, -0.58},    {"furrow", -0.12, -0.70},
    {"hairline", 5.51, -4.53},   {"hairline", 4.82, -3.13},   {"hairline", 4.50, -1.19},
    {"hairline", 3.51, -1.80},   {"hairline", 2.41, -2.35},   {"hairline", 1.10, -2.33},
    {"hairline", 0.04, -2.36},   {"hairline", -1.18, -2.35},  {"hairline", -2.22, -2.39},
    {"hairline", -3.17, -1.86},  {"hairline", -4.38, -1.25},  {"hairline", -4.67, -3.32},
    {"hairline", -5.34, -4.78},  {"lower_lip", -0.20, -1.58}, {"lower_lip", -0.25, -1.04},
    {"lower_lip", -0.38, -0.41}, {"lower_lip", -0.19, -0.37}, {"lower_lip", -0.24, 0.01},
    {"lower_lip", -0.18, 0.25},  {"lower_lip", -0.08, 0.42},  {"lower_lip", 0.02, 0.22},
    {"lower_lip", 0.07, -0.00},  {"lower_lip", 0.03, -0.36},  {"lower_lip", 0.25, -0.40},
    {"lower_lip", 0.11, -1.02},  {"lower_lip", 0.01, -1.65},  {"nose_tip", 7.83, 2.94},
    {"nose_tip", 6.03, 1.97},    {"nose_tip", 4.11, 1.26},    {"nose_tip", 2.10, 1.15},
    {"nose_tip", 0.07, 0.55},    {"nose_tip", -1.97, 1.08},   {"nose_tip", -4.00, 1.21},
    {"nose_tip", -5.95, 1.99},   {"nose_tip", -7.77, 3.02},   {"upper_lip", -0.20, -1.58},
    {"upper_lip", 0.42, -0.44},  {"upper_lip", 0.66, 0.65},   {"upper_lip", 0.28, 0.66},
    {"upper_lip", -0.01, 1.09},  {"upper_lip", -0.10, 1.92},  {"upper_lip", -0.10, 0.82},
    {"upper_lip", -0.11, 1.94},  {"upper_lip", -0.18, 1.08},  {"upper_lip", -0.52, 0.64},
    {"upper_lip", -0.87, 0.63},  {"upper_lip", -0.63, -0.50}, {"upper_lip", 0.01, -1.65},
}};

}  // namespace zygoma::hard
