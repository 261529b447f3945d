#include "src/io/library_versions.h"

#include <Eigen/Core>
#include <opencv2/core/utility.hpp>

extern "C" {
#include <libavutil/avutil.h>
}

namespace zygoma {

std::vector<std::pair<std::string, std::string>> library_versions() {
  const std::string eigen = std::to_string(EIGEN_WORLD_VERSION) + "." +
                            std::to_string(EIGEN_MAJOR_VERSION) + "." +
                            std::to_string(EIGEN_MINOR_VERSION);
  return {{"opencv", cv::getVersionString()}, {"eigen", eigen}, {"ffmpeg", av_version_info()}};
}

}  // namespace zygoma
