// A still picture as PNG or JPEG, by the ending of its name.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace zygoma {

// Throws InputError unless the name ends in .png, .jpg or .jpeg: before hours of work, not after.
void require_picture_name(const std::string& path);

// 8-bit BGR. Throws InputError naming the file when it cannot be written.
void write_picture(const std::string& path, const cv::Mat& bgr);

}  // namespace zygoma
