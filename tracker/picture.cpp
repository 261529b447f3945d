#include "tracker/picture.h"

#include <opencv2/imgproc.hpp>

namespace zygoma {
namespace {

// Planes of even size.
cv::Mat as_bgr(const cv::Mat& y, const cv::Mat& cb, const cv::Mat& cr) {
  // One below the other, two rows of chroma to a row.
  cv::Mat stacked(y.rows + y.rows / 2, y.cols, CV_8U), bgr;
  y.copyTo(stacked.rowRange(0, y.rows));
  std::uint8_t* chroma = stacked.ptr(y.rows);
  for (const cv::Mat* plane : {&cb, &cr}) {
    plane->copyTo(cv::Mat(plane->rows, plane->cols, CV_8U, chroma));
    chroma += plane->total();
  }
  cv::cvtColor(stacked, bgr, cv::COLOR_YUV2BGR_I420);
  return bgr;
}

}  // namespace

cv::Mat as_bgr(const cv::Mat& image) {
  cv::Mat bgr;
  if (image.empty() || image.depth() != CV_8U) return bgr;
  if (image.channels() == 3) return image;
  if (image.channels() == 1) cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  if (image.channels() == 4) cv::cvtColor(image, bgr, cv::COLOR_BGRA2BGR);
  return bgr;
}

Picture::Picture(const Frame& frame, bool turned)
    : image_(frame.image), planes_(frame.planes), turned_(turned) {
  const int channels = image_.channels();
  const bool usable = image_.depth() == CV_8U && (channels == 1 || channels == 3 || channels == 4);
  if (!image_.empty() && usable) size_ = image_.size();
  if (image_.empty()) size_ = planes_.y.size();
}

cv::Mat Picture::bgr(const cv::Rect& box) const {
  const int x = turned_ ? size_.width - box.x - box.width : box.x;
  const cv::Rect stored(x, box.y, box.width, box.height);
  cv::Mat out;
  if (!image_.empty()) {
    out = as_bgr(image_(stored));
  } else {
    const cv::Rect half(stored.x / 2,
                        stored.y / 2,
                        (stored.br().x + 1) / 2 - stored.x / 2,
                        (stored.br().y + 1) / 2 - stored.y / 2);
    const cv::Rect even(2 * half.x, 2 * half.y, 2 * half.width, 2 * half.height);
    out = as_bgr(planes_.y(even), planes_.cb(half), planes_.cr(half))(stored - even.tl());
  }
  if (!turned_) return out;
  cv::Mat flipped;
  cv::flip(out, flipped, 1);
  return flipped;
}

cv::Mat Picture::sparse(const cv::Size& size) const {
  const auto thinned = [](const cv::Mat& all, const cv::Size& wanted) {
    cv::Mat out;
    cv::resize(all, out, wanted, 0, 0, cv::INTER_LINEAR);
    return out;
  };
  cv::Mat out = !image_.empty() ? as_bgr(thinned(image_, size))
                                : as_bgr(thinned(planes_.y, size),
                                         thinned(planes_.cb, size / 2),
                                         thinned(planes_.cr, size / 2));
  if (turned_) cv::flip(out, out, 1);
  return out;
}

}  // namespace zygoma
