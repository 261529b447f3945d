// Written by the fit of tests/hard/tracker_confidence_test.cpp; see docs/tracking.md.
#pragma once

#include <array>

#include "tracker/confidence.h"

namespace zygoma {

struct NamedConfidenceMap {
  std::string_view contours;  // what the names of the contours begin with
  ConfidenceMap map;
};

// The last is for contours it was not fitted for.
inline constexpr std::array<NamedConfidenceMap, 9> kConfidenceMaps{{
    {"brow", {3.33, {1.37, 4.11, 1.03, 1.32, 0.78, 0.30}}},
    {"chin_boss", {2.18, {1.13, 2.82, 1.19, 0.86, 1.19, 0.30}}},
    {"eyelid", {3.71, {1.63, 1.24, 0.87, 1.32, 0.65, 0.30}}},
    {"furrow", {1.69, {0.30, 0.75, 0.72, 1.11, 0.69, 0.36}}},
    {"hairline", {4.50, {1.62, 1.60, 1.27, 1.49, 1.10, 0.30}}},
    {"lower_lip", {2.84, {1.03, 2.13, 0.90, 0.82, 0.34, 0.78}}},
    {"nose_tip", {2.88, {1.27, 1.12, 0.82, 1.16, 1.17, 0.30}}},
    {"upper_lip", {3.76, {1.51, 3.09, 0.67, 1.10, 0.40, 0.87}}},
    {"", {2.92, {1.27, 1.39, 0.80, 1.11, 0.63, 0.35}}},
}};

}  // namespace zygoma
