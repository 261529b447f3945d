// Where pictures come from: a video file, numbered pictures, or a camera.
//
// Numbered pictures are named by a pattern as FFmpeg's, "frames/%04d.png": one %d in the name of
// the file, optionally with a width and zeros. They are numbered without gaps, from any number. A
// camera is a Video4Linux device, read through FFmpeg's libavdevice. That library brings dozens of
// others (sound, windows, discs), so it is loaded when a camera is asked for and not before; where
// it is missing everything else works.
#pragma once

#include <memory>
#include <string>
#include <utility>

struct AVFormatContext;

namespace zygoma {

struct VideoSource {
  VideoSource() = default;
  VideoSource(std::string file) : path(std::move(file)) {}  // not explicit: a name is a source
  VideoSource(const char* file) : path(file) {}

  std::string path;  // of a file, a pattern, or a camera's device
  // Of pictures that have no time of their own, or asked of a camera; 0: the usual one.
  double frames_per_s = 0.0;
  bool is_camera = false;
  std::string camera_size;  // "640x480"; empty: as the camera is set
};

// The camera /dev/videoN.
VideoSource camera_source(int number);

inline constexpr double kUsualPictureRate = 25.0;  // frames/s of numbered pictures: FFmpeg's habit

// True for a pattern of numbered pictures, unless a file of that very name exists.
bool is_picture_pattern(const std::string& path);

// False for what is gone once it has been read: a camera, a pipe.
bool can_be_read_again(const VideoSource& source);

struct CloseContainer {
  void operator()(AVFormatContext* container) const;
};

struct OpenedSource {
  std::unique_ptr<AVFormatContext, CloseContainer> container;
  int num_pictures = 0;  // of a pattern; 0: somebody else may know
};

// Opens what will be demultiplexed. Throws InputError naming the source and what was expected.
OpenedSource open_source(const VideoSource& source);

// What the messages about unreadable files end with.
inline constexpr const char* kExpectedVideo =
    ", expected a video file (MP4, MOV, AVI, MKV, WebM, MPEG ...)";

}  // namespace zygoma
