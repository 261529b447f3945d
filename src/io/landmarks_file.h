// 68 landmarks per frame from a CSV file as OpenFace writes it (docs/formats.md): columns frame,
// timestamp, confidence, success, x_0 .. x_67, y_0 .. y_67, found by name, with or without blanks
// around the names. Other columns do not matter.
#pragma once

#include <map>
#include <string>

#include "tracker/landmarks.h"

namespace zygoma {

struct LandmarkTrack {
  std::string path;
  int num_frames = 0;             // that the file speaks of
  std::map<int, Landmarks> seen;  // by frame, from 0: those with success and some confidence
};

// OpenFace counts frames from 1; a file whose first frame is 0 is taken at its word. Throws
// InputError naming file, line, column, value and what was expected.
LandmarkTrack read_landmarks_csv(const std::string& path);

}  // namespace zygoma
