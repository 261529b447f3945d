// Writes an H.264 MP4 with libavcodec, one picture per given time stamp (variable rate kept), to
// PATH.part, renamed to PATH by finish(). Without finish() no file is left under the final name.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

namespace zygoma {

struct VideoWriterOptions {
  std::string preset = "superfast";  // x264's: ultrafast ... veryslow; slower = smaller files
  int constant_rate_factor = 20;     // [0, 51], 18 = hardly any visible loss, +6 = half the size
  int num_threads = 2;
};

class VideoWriter {
 public:
  // Sizes are rounded up to even numbers by repeating the last row or column.
  // Throws InputError naming the path when it cannot be written.
  VideoWriter(const std::string& path,
              int width_px,
              int height_px,
              double average_frames_per_s,
              const VideoWriterOptions& options = {});
  ~VideoWriter();  // discards an unfinished file

  // 8-bit BGR of the size given; time stamps must increase.
  void write(const cv::Mat& bgr, double time_s);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
