// The shape parameters of a head with their ranges (Identity::check), for tests that vary them all.
#pragma once

#include <vector>

#include "face/generic_head.h"

namespace zygoma::test_support {

struct ShapeParameter {
  double Identity::*value;
  double low;
  double high;
};

inline const std::vector<ShapeParameter>& shape_parameters() {
  static const std::vector<ShapeParameter> all{{&Identity::face_width, 0.88, 1.14},
                                               {&Identity::face_height, 0.90, 1.12},
                                               {&Identity::jaw_width, 0.85, 1.18},
                                               {&Identity::nose_length, 0.85, 1.18},
                                               {&Identity::nose_width, 0.80, 1.30},
                                               {&Identity::lip_fullness, 0.70, 1.45},
                                               {&Identity::brow_height_mm, -4.0, 5.0},
                                               {&Identity::eye_distance, 0.93, 1.08},
                                               {&Identity::chin_length, 0.85, 1.20}};
  return all;
}

}  // namespace zygoma::test_support
