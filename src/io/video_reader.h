// Decodes a video file, numbered pictures or a camera with FFmpeg, strictly in order.
//
// Time comes from the container: the stamp of each picture. Stamps that do not increase continue
// with the last step and are counted as repaired; raw streams without time fall back to
// index / rate, and numbered pictures have no other time. Frame count and rate of the container are
// hints only. Rotation tags are applied.
//
// FFmpeg itself and not OpenCV on top of it, because OpenCV 4.6 loses the stamps of the last
// pictures of H.264 files, turns telephones' portrait videos the wrong way, ignores the colour
// matrix of the file, and brings a hundred libraries that have to be loaded before the program
// can start.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "src/base/stop.h"
#include "src/io/video_source.h"
#include "tracker/frame.h"

namespace zygoma {

struct VideoInfo {
  std::string path;
  int width_px = 0;  // as delivered, rotation applied
  int height_px = 0;
  int about_num_frames = 0;         // the container's claim; 0 when it makes none that is credible
  double average_frames_per_s = 0;  // the container's claim; 30 when it makes none that is credible
  int rotation_deg = 0;
  double pixel_aspect = 1.0;  // width of a pixel over its height
};

class VideoReader {
 public:
  // Throws InputError naming the source: missing, not a video, no picture in it. `stop` is asked
  // while a camera has no picture yet.
  explicit VideoReader(const VideoSource& source, const StopQuestion& stop = {});
  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;

  const VideoInfo& info() const;

  // False at the end, and when the rest cannot be decoded. `frame.image` is reused.
  bool read(Frame& frame);
  // The same, but pictures stored as planes (tracker/frame.h), upright, are handed over as they
  // are: nothing is converted or copied. `frame.image` is empty then.
  bool read_planes(Frame& frame);

  // Indices of frames whose time stamp had to be repaired.
  const std::vector<int>& repaired_timestamps() const;
  // False for a raw stream and for numbered pictures: all times are index / rate.
  bool has_time_stamps() const;
  // True when reading ended clearly before the container's claim (a truncated file).
  bool ended_early() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
