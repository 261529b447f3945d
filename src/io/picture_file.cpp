#include "src/io/picture_file.h"

#include <opencv2/imgcodecs.hpp>

#include "src/base/check.h"
#include "src/io/atomic_file.h"

namespace zygoma {

void require_picture_name(const std::string& path) {
  require(path.ends_with(".png") || path.ends_with(".jpg") || path.ends_with(".jpeg"),
          path + ": unknown kind of picture, expected a name that ends in .png or .jpg");
}

void write_picture(const std::string& path, const cv::Mat& bgr) {
  require_picture_name(path);
  std::vector<unsigned char> bytes;
  cv::imencode(path.substr(path.rfind('.')), bgr, bytes);
  AtomicFile file(path);
  file.stream().write(reinterpret_cast<const char*>(bytes.data()),
                      static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

}  // namespace zygoma
