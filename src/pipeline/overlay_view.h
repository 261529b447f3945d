// The picture that tells at a glance how tracking went:
//
//   the video with its contours and the head frame      the brows and the mouth, close
//   confidence of every contour over the whole clip     the scale of colours, what is lost
//
// The close-ups are resampled by the head's similarity: the head stands still in them, so what
// moves is expression, and a contour that slips against the skin is seen to slip. A ruler says how
// large the pixels of the video are there.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "tracker/head_frame.h"

namespace zygoma {

class OverlayView {
 public:
  // One entry per frame; both must outlive the view. A head maps chart to image.
  OverlayView(cv::Size video_px,
              const std::vector<ContourSet>& contours,
              const std::vector<std::optional<Similarity>>& heads);

  cv::Size size_px() const { return background_.size(); }
  // The view of a frame of the video, BGR, valid until the next call.
  const cv::Mat& draw(int frame, const cv::Mat& picture);

 private:
  void draw_video(int frame, const cv::Mat& picture);
  void draw_close_up(int frame,
                     const cv::Mat& picture,
                     const cv::Rect& panel,
                     const Point2& middle,
                     double px_per_chart_px);
  void draw_strip();
  void draw_scale();

  const std::vector<ContourSet>& contours_;
  const std::vector<std::optional<Similarity>>& heads_;
  double video_scale_ = 1.0;
  cv::Rect video_, strip_, brow_right_, brow_left_, mouth_, scale_;
  cv::Mat background_;  // what is the same in all frames
  cv::Mat canvas_;
};

}  // namespace zygoma
