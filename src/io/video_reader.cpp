#include "src/io/video_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "src/base/check.h"
#include "src/io/quiet.h"
#include "src/io/rotation_tag.h"
#include "src/io/video_clock.h"

namespace zygoma {
namespace {

constexpr const char* kExpected = ", expected a video file (MP4, MOV, AVI, MKV, WebM, MPEG ...)";
constexpr double kFallbackFramesPerSecond = 30.0;
constexpr double kLargestCredibleRate = 1000.0;
constexpr double kLargestCredibleCount = 1e8;

void require_readable(const std::string& path) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  require(std::filesystem::exists(status), path + ": no such file" + kExpected);
  require(!std::filesystem::is_directory(status), path + ": is a folder" + kExpected);
  const bool is_stream =
      std::filesystem::is_regular_file(status) || std::filesystem::is_fifo(status);
  require(is_stream, path + ": is not a regular file" + kExpected);
  const bool is_empty = std::filesystem::is_regular_file(status) &&
                        std::filesystem::file_size(path, failure) == 0 && !failure;
  require(!is_empty, path + ": is empty" + kExpected);
}

// FFmpeg draws text files whose name says so (.txt, .nfo) as pictures of a terminal.
bool is_text_art(const cv::VideoCapture& capture) {
  const int fourcc = static_cast<int>(capture.get(cv::CAP_PROP_FOURCC));
  return fourcc == cv::VideoWriter::fourcc('a', 'n', 's', 'i');
}

double credible_rate(double claim) {
  const bool credible = std::isfinite(claim) && claim > 0.0 && claim <= kLargestCredibleRate;
  return credible ? claim : kFallbackFramesPerSecond;
}

VideoInfo info_of(const cv::VideoCapture& capture,
                  const std::string& path,
                  int rotation_deg,
                  cv::Size shown) {
  VideoInfo info;
  info.path = path;
  info.width_px = shown.width;
  info.height_px = shown.height;
  const double count = capture.get(cv::CAP_PROP_FRAME_COUNT);
  if (count > 0 && count < kLargestCredibleCount) info.about_num_frames = static_cast<int>(count);
  info.average_frames_per_s = credible_rate(capture.get(cv::CAP_PROP_FPS));
  info.rotation_deg = rotation_deg;
  const double sar_num = capture.get(cv::CAP_PROP_SAR_NUM);
  const double sar_den = capture.get(cv::CAP_PROP_SAR_DEN);
  if (sar_num > 0 && sar_den > 0) {
    const bool upright = info.rotation_deg % 180 == 0;
    info.pixel_aspect = upright ? sar_num / sar_den : sar_den / sar_num;
  }
  return info;
}

}  // namespace

struct VideoReader::Impl {
  cv::VideoCapture capture;
  VideoInfo info;
  VideoClock clock{kFallbackFramesPerSecond};
  cv::Mat first_picture;  // decoded by the constructor, delivered by the first read()
  cv::Mat as_stored;      // before it is turned
  double first_stamp_s = 0.0;
  int rotation_deg = 0;
  int num_read = 0;
  bool at_end = false;

  bool decode(cv::Mat& image) {
    if (rotation_deg % 180 == 0) {
      if (!capture.read(image) || image.empty()) return false;
      if (rotation_deg == 180) cv::flip(image, image, -1);
      return true;
    }
    if (!capture.read(as_stored) || as_stored.empty()) return false;
    const bool clockwise = rotation_deg == 90;
    cv::rotate(
        as_stored, image, clockwise ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE);
    return true;
  }

  double stamp_s() const { return capture.get(cv::CAP_PROP_POS_MSEC) / 1000.0; }

  bool next_picture(cv::Mat& image, double& stamp) {
    if (num_read == 0) {
      cv::swap(image, first_picture);
      first_picture.release();
      stamp = first_stamp_s;
      return true;
    }
    if (!decode(image)) return false;
    stamp = stamp_s();
    const cv::Size size(info.width_px, info.height_px);
    // A stream may change its size on the way; what follows counts on one size.
    if (image.size() != size) cv::resize(image, image, size, 0, 0, cv::INTER_AREA);
    return true;
  }
};

VideoReader::VideoReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  require_readable(path);
  silence_video_libraries();
  // The absolute name, because FFmpeg takes "take1:2.mp4" for an address.
  const std::string absolute = std::filesystem::absolute(path).string();
  const bool opened = impl_->capture.open(absolute, cv::CAP_FFMPEG) && !is_text_art(impl_->capture);
  require(opened,
          path + ": cannot be read as a video (another kind of file, or cut off before its index)" +
              kExpected);
  impl_->capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  // A pipe cannot be opened twice, and has no tag in practice.
  if (!std::filesystem::is_fifo(absolute)) impl_->rotation_deg = rotation_tag_deg(absolute);
  const bool has_picture = impl_->decode(impl_->first_picture);
  require(has_picture, path + ": no picture in it can be decoded" + kExpected);
  impl_->first_stamp_s = impl_->stamp_s();
  impl_->info = info_of(impl_->capture, path, impl_->rotation_deg, impl_->first_picture.size());
  impl_->clock = VideoClock(impl_->info.average_frames_per_s);
}

VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;

const VideoInfo& VideoReader::info() const { return impl_->info; }

bool VideoReader::read(Frame& frame) {
  double stamp_s = 0.0;
  if (impl_->at_end || !impl_->next_picture(frame.image, stamp_s)) {
    impl_->at_end = true;
    return false;
  }
  frame.index = impl_->num_read++;
  frame.time_s = impl_->clock.next(stamp_s);
  return true;
}

const std::vector<int>& VideoReader::repaired_timestamps() const { return impl_->clock.repaired(); }

bool VideoReader::has_time_stamps() const { return impl_->clock.has_time(); }

bool VideoReader::ended_early() const {
  // Containers overstate by a few frames (Matroska: 122 for 120), so a little less is no sign.
  const int claim = impl_->info.about_num_frames;
  const int allowed = std::max(5, claim / 50);
  return impl_->at_end && claim > 0 && impl_->num_read < claim - allowed;
}

}  // namespace zygoma
