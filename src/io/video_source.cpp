#include "src/io/video_source.h"

#include <dlfcn.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <new>
#include <set>
#include <utility>
#include <vector>

extern "C" {
#include <libavformat/avformat.h>
}

#include "src/base/check.h"

namespace zygoma {
namespace {

namespace fs = std::filesystem;

constexpr double kLowestRate = 0.1;
constexpr double kHighestRate = 1000.0;

// The options of a demultiplexer.
class Settings {
 public:
  ~Settings() { av_dict_free(&entries_); }
  void set(const char* name, const std::string& value) {
    av_dict_set(&entries_, name, value.c_str(), 0);
  }
  AVDictionary** get() { return &entries_; }

 private:
  AVDictionary* entries_ = nullptr;
};

// 0, or the reason as a negative number.
int open_container(OpenedSource& opened,
                   const std::string& address,
                   const AVInputFormat* format,
                   Settings& settings,
                   int flags = 0) {
  AVFormatContext* container = avformat_alloc_context();
  if (container == nullptr) throw std::bad_alloc();
  container->flags |= flags;
  const int status = avformat_open_input(&container, address.c_str(), format, settings.get());
  if (status >= 0) opened.container.reset(container);
  return status;
}

std::string reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

void require_readable(const std::string& path) {
  std::error_code failure;
  const auto status = fs::status(path, failure);
  require(fs::exists(status), path + ": no such file" + kExpectedVideo);
  require(!fs::is_directory(status),
          path + ": is a folder" + kExpectedVideo + " or a pattern of pictures such as " +
              (fs::path(path) / "%04d.png").string());
  const bool is_stream = fs::is_regular_file(status) || fs::is_fifo(status);
  require(is_stream, path + ": is not a regular file" + kExpectedVideo);
  const bool is_empty =
      fs::is_regular_file(status) && fs::file_size(path, failure) == 0 && !failure;
  require(!is_empty, path + ": is empty" + kExpectedVideo);
}

// "shot_%04d.png": what stands before and after the number, and how wide the number is at least.
struct Pattern {
  bool ok = false;
  std::string before;
  std::string after;
  int width = 0;
};

// "%%" stands for a percent sign.
std::string plain_text(const std::string& text, bool& ok) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    out += text[i];
    if (text[i] != '%') continue;
    ++i;
    ok = ok && i < text.size() && text[i] == '%';
  }
  return out;
}

Pattern parse_pattern(const std::string& name) {
  Pattern pattern;
  for (std::size_t at = name.find('%'); at != std::string::npos; at = name.find('%', at)) {
    std::size_t end = at + 1;
    if (end < name.size() && name[end] == '%') {
      at = end + 1;
      continue;
    }
    while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
    if (end == name.size() || name[end] != 'd' || end - at > 3) return pattern;
    std::from_chars(name.data() + at + 1, name.data() + end, pattern.width);
    pattern.ok = true;
    pattern.before = plain_text(name.substr(0, at), pattern.ok);
    pattern.after = plain_text(name.substr(end + 1), pattern.ok);
    return pattern;
  }
  return pattern;
}

// The number of a picture that the pattern names, or -1.
int number_in(const std::string& name, const Pattern& pattern) {
  const std::size_t around = pattern.before.size() + pattern.after.size();
  if (name.size() <= around || !name.starts_with(pattern.before) ||
      !name.ends_with(pattern.after)) {
    return -1;
  }
  const char* begin = name.data() + pattern.before.size();
  const char* end = name.data() + name.size() - pattern.after.size();
  int number = -1;
  const auto read = std::from_chars(begin, end, number);
  if (read.ec != std::errc() || read.ptr != end || *begin == '-') return -1;
  // Written back, it must be the same name: "7" is not what %04d finds.
  const auto digits = static_cast<std::size_t>(end - begin);
  const std::size_t needed = std::to_string(number).size();
  return digits == std::max(needed, static_cast<std::size_t>(pattern.width)) ? number : -1;
}

OpenedSource open_pictures(const VideoSource& source) {
  const fs::path path(source.path);
  const Pattern pattern = parse_pattern(path.filename().string());
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code failure;
  std::set<int> numbers;
  for (fs::directory_iterator file(folder, failure), end; !failure && file != end;
       file.increment(failure)) {
    const int number = number_in(file->path().filename().string(), pattern);
    if (number >= 0) numbers.insert(number);
  }
  require(!numbers.empty(),
          source.path +
              ": no picture has such a name, expected numbered pictures (%04d stands "
              "for 0000, 0001 ...)");
  const int first = *numbers.begin();
  const int last = *numbers.rbegin();
  for (int number = first; number <= last; ++number) {
    require(numbers.contains(number),
            source.path + ": picture " + std::to_string(number) +
                " is missing, expected all from " + std::to_string(first) + " to " +
                std::to_string(last));
  }
  // In the folder's part of the address a percent sign would be another pattern.
  std::string address = fs::absolute(folder, failure).string() + "/";
  for (std::size_t at = address.find('%'); at != std::string::npos;
       at = address.find('%', at + 2)) {
    address.insert(at, 1, '%');
  }
  Settings settings;
  const double rate = source.frames_per_s > 0.0 ? source.frames_per_s : kUsualPictureRate;
  settings.set("framerate", shortest_text(rate));
  settings.set("start_number", std::to_string(first));
  OpenedSource opened;
  const int status = open_container(
      opened, address + path.filename().string(), av_find_input_format("image2"), settings);
  require(status >= 0,
          source.path + ": cannot be read as pictures (" + reason(status) +
              "), expected PNG, JPEG or the like");
  opened.num_pictures = last - first + 1;
  return opened;
}

OpenedSource open_file(const VideoSource& source) {
  require_readable(source.path);
  Settings settings;
  settings.set("protocol_whitelist", "file");  // a playlist must not call the network
  OpenedSource opened;
  // The absolute name, because FFmpeg takes "take1:2.mp4" for an address.
  const int status = open_container(opened, fs::absolute(source.path).string(), nullptr, settings);
  require(status >= 0,
          source.path +
              ": cannot be read as a video (another kind of file, or cut off before its index)" +
              kExpectedVideo);
  const bool has_time = (opened.container->iformat->flags & AVFMT_NOTIMESTAMPS) == 0;
  require(source.frames_per_s == 0.0 || !has_time,
          source.path +
              ": has time stamps of its own; a frame rate is for numbered pictures, raw streams "
              "and cameras");
  return opened;
}

// Null where FFmpeg's library of devices, of the version that belongs to the rest, is not there.
const AVInputFormat* camera_format() {
  const std::string name = "libavdevice.so." + std::to_string(LIBAVFORMAT_VERSION_MAJOR);
  void* library = dlopen(name.c_str(), RTLD_NOW);  // stays: FFmpeg keeps what it registers
  void* symbol = library == nullptr ? nullptr : dlsym(library, "avdevice_register_all");
  if (symbol == nullptr) return nullptr;
  reinterpret_cast<void (*)()>(symbol)();
  return av_find_input_format("video4linux2,v4l2");
}

std::string cameras_there() {
  std::vector<std::string> names;
  std::error_code failure;
  for (fs::directory_iterator file("/dev", failure), end; !failure && file != end;
       file.increment(failure)) {
    const std::string name = file->path().filename().string();
    if (name.starts_with("video")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "/dev/" : ", /dev/") + name;
  return text.empty() ? "there is none" : "there are " + text;
}

void require_picture_size(const std::string& size) {
  if (size.empty()) return;
  int width = 0;
  int height = 0;
  const char* end = size.data() + size.size();
  const auto after_width = std::from_chars(size.data(), end, width);
  const bool has_x = after_width.ptr != end && *after_width.ptr == 'x';
  const auto after_height = has_x ? std::from_chars(after_width.ptr + 1, end, height) : after_width;
  require(has_x && after_height.ptr == end && width > 0 && height > 0,
          "camera size is '" + size + "', expected WIDTHxHEIGHT in pixels such as 640x480");
}

OpenedSource open_camera(const VideoSource& source) {
  require_picture_size(source.camera_size);
  std::error_code failure;
  require(
      fs::exists(source.path, failure),
      source.path + ": no such camera, expected one of those connected (" + cameras_there() + ")");
  const AVInputFormat* format = camera_format();
  require(format != nullptr,
          source.path +
              ": cameras need FFmpeg's libavdevice with Video4Linux, which is not installed "
              "(Debian: libavdevice-dev)");
  Settings settings;
  if (source.frames_per_s > 0.0) settings.set("framerate", shortest_text(source.frames_per_s));
  if (!source.camera_size.empty()) settings.set("video_size", source.camera_size);
  OpenedSource opened;
  // Reads return at once when there is no picture yet, so that a stop need not wait for one.
  const int status = open_container(opened, source.path, format, settings, AVFMT_FLAG_NONBLOCK);
  require(status >= 0,
          source.path + ": cannot be used as a camera (" + reason(status) +
              "), expected a Video4Linux camera that nobody else uses and that offers the size "
              "and rate asked for");
  return opened;
}

}  // namespace

void CloseContainer::operator()(AVFormatContext* container) const {
  avformat_close_input(&container);
}

VideoSource camera_source(int number) {
  VideoSource source("/dev/video" + std::to_string(number));
  source.is_camera = true;
  return source;
}

bool is_picture_pattern(const std::string& path) {
  std::error_code failure;
  return parse_pattern(fs::path(path).filename().string()).ok && !fs::exists(path, failure);
}

bool can_be_read_again(const VideoSource& source) {
  std::error_code failure;
  return !source.is_camera && !fs::is_fifo(source.path, failure);
}

OpenedSource open_source(const VideoSource& source) {
  if (source.frames_per_s != 0.0) {
    require_range("frame rate", source.frames_per_s, kLowestRate, kHighestRate);
  }
  if (source.is_camera) return open_camera(source);
  return is_picture_pattern(source.path) ? open_pictures(source) : open_file(source);
}

}  // namespace zygoma
