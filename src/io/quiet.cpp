#include "src/io/quiet.h"

#include <cstdarg>
#include <mutex>
#include <opencv2/core/utils/logger.hpp>

extern "C" {
#include <libavutil/log.h>
}

namespace zygoma {

void silence_video_libraries() {
  static std::once_flag once;
  std::call_once(once, [] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    // OpenCV sets FFmpeg's log level anew whenever it opens a file, but leaves the receiver of the
    // messages alone unless the user asks for them (OPENCV_FFMPEG_DEBUG).
    av_log_set_callback([](void*, int, const char*, va_list) {});
  });
}

}  // namespace zygoma
