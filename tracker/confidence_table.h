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
    {"brow", {3.42, {1.55, 3.37, 1.01, 1.33, 0.72, 0.30}}},
    {"chin_boss", {2.34, {1.48, 3.25, 1.24, 0.89, 1.22, 0.30}}},
    {"eyelid", {3.71, {1.99, 1.15, 0.85, 1.28, 0.62, 0.30}}},
    {"furrow", {1.90, {0.50, 0.54, 0.66, 1.02, 0.90, 0.81}}},
    {"hairline", {4.41, {1.83, 1.56, 1.30, 1.46, 1.06, 0.30}}},
    {"lower_lip", {3.05, {1.06, 2.26, 0.95, 0.91, 0.54, 0.67}}},
    {"nose_tip", {3.04, {1.69, 1.12, 0.88, 1.10, 1.09, 0.30}}},
    {"upper_lip", {3.94, {1.59, 2.94, 0.88, 1.12, 0.58, 1.01}}},
    {"", {3.00, {1.56, 1.30, 0.86, 1.11, 0.74, 0.35}}},
}};

}  // namespace zygoma
