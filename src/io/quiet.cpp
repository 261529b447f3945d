#include "src/io/quiet.h"

#include <mutex>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

extern "C" {
#include <libavutil/log.h>
}

namespace zygoma {

void silence_video_libraries() {
  static std::once_flag once;
  std::call_once(once, [] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    // OpenCV sets FFmpeg's level when its back end is first used; opening nothing gets that over
    // with, so that our level is the last word.
    cv::VideoCapture().open("", cv::CAP_FFMPEG);
    av_log_set_level(AV_LOG_QUIET);
  });
}

}  // namespace zygoma
