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

cv::Rect Picture::stored(const cv::Rect& box) const {
  return turned_ ? cv::Rect(size_.width - box.br().x, box.y, box.width, box.height) : box;
}

cv::Mat Picture::turned(const cv::Mat& part) const {
  if (!turned_) return part;
  cv::Mat out;
  cv::flip(part, out, 1);
  return out;
}

cv::Mat Picture::bgr(const cv::Rect& box) const {
  const cv::Rect part = stored(box);
  if (!image_.empty()) return turned(as_bgr(image_(part)));
  const cv::Rect half(cv::Point(part.x / 2, part.y / 2),
                      cv::Point((part.br().x + 1) / 2, (part.br().y + 1) / 2));
  const cv::Rect even(half.tl() * 2, half.size() * 2);
  // Turned while it is planes: a third of the work.
  const cv::Mat whole =
      as_bgr(turned(planes_.y(even)), turned(planes_.cb(half)), turned(planes_.cr(half)));
  const int left = turned_ ? even.br().x - part.br().x : part.x - even.x;
  return whole(cv::Rect(cv::Point(left, part.y - even.y), part.size()));
}

cv::Mat Picture::grey(const cv::Rect& box) const {
  cv::Mat grey;
  if (!image_.empty()) {
    cv::cvtColor(as_bgr(image_(stored(box))), grey, cv::COLOR_BGR2GRAY);
  } else {
    planes_.y(stored(box)).convertTo(grey, CV_8U, 255.0 / 219.0, -16.0 * 255.0 / 219.0);
  }
  return turned(grey);
}

cv::Mat Picture::sparse(const cv::Size& size) const {
  const auto thinned = [](const cv::Mat& all, const cv::Size& wanted) {
    cv::Mat out;
    cv::resize(all, out, wanted, 0, 0, cv::INTER_LINEAR);
    return out;
  };
  return turned(!image_.empty() ? as_bgr(thinned(image_, size))
                                : as_bgr(thinned(planes_.y, size),
                                         thinned(planes_.cb, size / 2),
                                         thinned(planes_.cr, size / 2)));
}

}  // namespace zygoma
