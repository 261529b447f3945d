// How far the pictures of a video file must be turned before they are shown.
//
// Read with FFmpeg itself: OpenCV 4.6 on FFmpeg 5 turns the picture the wrong way (a telephone's
// portrait video arrives upside down), so the reader switches that off and turns by this.
#pragma once

#include <string>

namespace zygoma {

// Clockwise, one of 0, 90, 180, 270; 0 for files without a tag and for what cannot be opened.
int rotation_tag_deg(const std::string& path);

}  // namespace zygoma
