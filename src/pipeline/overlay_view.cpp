#include "src/pipeline/overlay_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

#include "src/pipeline/overlay.h"
#include "tracker/face_chart.h"
#include "tracker/feature_schema.h"

namespace zygoma {
namespace {

constexpr int kHeight_px = 768;
constexpr int kSide_px = 640;  // width of the close-ups
constexpr int kMargin_px = 8;
constexpr int kTitle_px = 22;          // a line of text above each part
constexpr int kMouth_px = 382;         // height
constexpr int kBrow_px = 244;          // height
constexpr int kLargestVideo_px = 960;  // width
constexpr int kSmallestVideo_px = 480;
constexpr int kRow_px = 13;    // of the strip
constexpr int kNames_px = 92;  // beside the strip

// What the close-ups show, eye distances about the eye middle; heights follow from the panels.
constexpr double kBrowX = 0.56, kBrowY = -0.27, kBrowWidth = 1.06;
constexpr double kMouthX = 0.0, kMouthY = 1.335, kMouthWidth = 2.0;

const cv::Scalar kPaper(38, 35, 32);
const cv::Scalar kEmpty(58, 54, 50);
const cv::Scalar kInk(215, 212, 208);
const cv::Scalar kFaint(140, 136, 132);
const cv::Scalar kHead(255, 235, 190);  // pale blue: no colour of the scale
const cv::Scalar kAlarm(90, 120, 255);

void write(cv::Mat& canvas,
           const std::string& text,
           cv::Point at,
           const cv::Scalar& ink,
           double size = 0.42) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

int text_width_px(const std::string& text, double size = 0.42) {
  int baseline = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline).width;
}

// "brow_left" -> "brow left"
std::string spoken(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

cv::Point rounded(const Point2& p) {
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
}

// A thin line with a dark rim.
void draw_line(cv::Mat& canvas, const Point2& a, const Point2& b) {
  cv::line(canvas, rounded(a), rounded(b), kPaper, 3, cv::LINE_AA);
  cv::line(canvas, rounded(a), rounded(b), kHead, 1, cv::LINE_AA);
}

// Corners of the face, a cross between the eyes, an axis down to the base of the nose.
void draw_head(const Similarity& canvas_from_chart, cv::Mat& canvas) {
  const auto at = [&](double x, double y) { return canvas_from_chart.apply(chart_point(x, y)); };
  draw_line(canvas, at(-0.12, 0.0), at(0.12, 0.0));
  draw_line(canvas, at(0.0, -0.12), at(0.0, 0.3));
  for (const double side : {-1.0, 1.0}) {
    draw_line(canvas, at(0.5 * side - 0.04, 0.0), at(0.5 * side + 0.04, 0.0));
    draw_line(canvas, at(0.5 * side, -0.04), at(0.5 * side, 0.04));
    for (const auto& [y, inwards] : {std::pair{-1.35, 1.0}, std::pair{2.15, -1.0}}) {
      draw_line(canvas, at(1.25 * side, y), at(1.05 * side, y));
      draw_line(canvas, at(1.25 * side, y), at(1.25 * side, y + 0.2 * inwards));
    }
  }
}

}  // namespace

OverlayView::OverlayView(cv::Size video_px,
                         const std::vector<ContourSet>& contours,
                         const std::vector<std::optional<Similarity>>& heads)
    : contours_(contours), heads_(heads) {
  const int rows = static_cast<int>(kFeatureSchema.size());
  const int strip_px = rows * kRow_px;
  const int most_px = kHeight_px - strip_px - 2 * kTitle_px - 3 * kMargin_px;
  video_scale_ = std::min(static_cast<double>(kLargestVideo_px) / video_px.width,
                          static_cast<double>(most_px) / video_px.height);
  const int width = std::max(1, static_cast<int>(std::lround(video_scale_ * video_px.width)));
  const int height = std::max(1, static_cast<int>(std::lround(video_scale_ * video_px.height)));
  const int left_px = std::max(kSmallestVideo_px, width);
  const int top = kMargin_px + kTitle_px;
  video_ = {kMargin_px + (left_px - width) / 2, top + (most_px - height) / 2, width, height};
  strip_ = {
      kMargin_px + kNames_px, kHeight_px - kMargin_px - strip_px, left_px - kNames_px, strip_px};
  const int x = 2 * kMargin_px + left_px;
  const int half = (kSide_px - kMargin_px) / 2;
  brow_right_ = {x, top, half, kBrow_px};
  brow_left_ = {x + half + kMargin_px, top, half, kBrow_px};
  mouth_ = {x, top + kBrow_px + kTitle_px + kMargin_px, kSide_px, kMouth_px};
  scale_ = {x, mouth_.br().y + kTitle_px + kMargin_px, 200, 14};
  background_ = cv::Mat(kHeight_px, (x + kSide_px + kMargin_px + 1) / 2 * 2, CV_8UC3, kPaper);
  const auto title = [&](const cv::Rect& panel, const std::string& text) {
    write(background_, text, {panel.x, panel.y - 7}, kInk);
  };
  title(brow_right_, "right brow, the head held still");
  title(brow_left_, "left brow");
  title(mouth_, "mouth");
  title(strip_, "confidence over the clip");
  title(scale_, "confidence");
  draw_strip();
  draw_scale();
}

// One row per contour, one column per share of the clip; the least confidence of its frames shows.
void OverlayView::draw_strip() {
  const int num_frames = static_cast<int>(contours_.size());
  for (size_t f = 0; f < kFeatureSchema.size(); ++f) {
    const int y = strip_.y + static_cast<int>(f) * kRow_px;
    write(background_, spoken(kFeatureSchema[f].name), {kMargin_px, y + kRow_px - 3}, kInk, 0.38);
    for (int x = 0; x < strip_.width && num_frames > 0; ++x) {
      const int first = static_cast<int>(static_cast<long>(x) * num_frames / strip_.width);
      const int next = static_cast<int>(static_cast<long>(x + 1) * num_frames / strip_.width);
      double least = 1.0;
      for (int k = first; k < std::max(first + 1, next); ++k) {
        const Contour* contour = contours_[k].visible(kFeatureSchema[f].name);
        least = std::min(least, contour == nullptr ? -1.0 : contour->confidence);
      }
      const cv::Scalar colour = least < 0.0 ? kEmpty : confidence_colour(least);
      cv::rectangle(background_, {strip_.x + x, y, 1, kRow_px - 2}, colour, cv::FILLED);
    }
  }
}

void OverlayView::draw_scale() {
  for (int x = 0; x < scale_.width; ++x) {
    const double confidence = static_cast<double>(x) / (scale_.width - 1);
    cv::rectangle(background_,
                  {scale_.x + x, scale_.y, 1, scale_.height},
                  confidence_colour(confidence),
                  cv::FILLED);
  }
  const int y = scale_.br().y + 14;
  write(background_, "0", {scale_.x, y}, kFaint, 0.38);
  write(background_, "0.5", {scale_.x + scale_.width / 2 - 10, y}, kFaint, 0.38);
  write(background_, "1", {scale_.br().x - 8, y}, kFaint, 0.38);
  const cv::Rect box(scale_.br().x + 24, scale_.y, 26, scale_.height);
  cv::rectangle(background_, box, kEmpty, cv::FILLED);
  cv::rectangle(background_, box, kFaint);
  write(background_, "lost", {box.x, y}, kFaint, 0.38);
}

void OverlayView::draw_video(int frame, const cv::Mat& picture) {
  cv::Mat panel = canvas_(video_);
  cv::resize(
      picture, panel, video_.size(), 0, 0, video_scale_ < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  const Similarity place = enlargement(video_scale_);
  if (heads_[frame]) draw_head(place.after(*heads_[frame]), panel);
  draw_contours(contours_[frame], place, {2, false}, panel);
}

void OverlayView::draw_close_up(int frame,
                                const cv::Mat& picture,
                                const cv::Rect& area,
                                const Point2& middle,
                                double px_per_chart_px) {
  cv::Mat panel = canvas_(area);
  if (!heads_[frame]) {
    panel.setTo(kEmpty);
    write(panel, "no face", {area.width / 2 - 28, area.height / 2}, kInk);
    return;
  }
  const Point2 centre(0.5 * (area.width - 1), 0.5 * (area.height - 1));
  const Similarity chart_from_panel{1.0 / px_per_chart_px, 0.0, middle - centre / px_per_chart_px};
  const Similarity image_from_panel = heads_[frame]->after(chart_from_panel);
  const cv::Matx23d matrix(image_from_panel.a,
                           -image_from_panel.b,
                           image_from_panel.shift.x(),
                           image_from_panel.b,
                           image_from_panel.a,
                           image_from_panel.shift.y());
  cv::warpAffine(picture,
                 panel,
                 matrix,
                 area.size(),
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT,
                 kEmpty);
  draw_contours(contours_[frame], image_from_panel.inverse(), {1, true}, panel);

  // A ruler of some pixels of the video.
  const double magnification = 1.0 / image_from_panel.scale();
  const int num_px = magnification >= 4.0 ? 5 : 10;
  const int length = static_cast<int>(std::lround(num_px * magnification));
  const cv::Point end(area.width - 10, area.height - 10);
  const std::string label = std::to_string(num_px) + " px";
  const cv::Rect plate(end.x - length - text_width_px(label, 0.38) - 14,
                       end.y - 11,
                       length + text_width_px(label, 0.38) + 20,
                       17);
  cv::Mat shade = panel(plate & cv::Rect(0, 0, area.width, area.height));
  shade.convertTo(shade, -1, 0.35);
  write(panel, label, {plate.x + 4, end.y + 2}, kInk, 0.38);
  cv::line(panel, {end.x - length, end.y - 2}, {end.x, end.y - 2}, kInk, 2);
}

const cv::Mat& OverlayView::draw(int frame, const cv::Mat& picture) {
  background_.copyTo(canvas_);
  const ContourSet& set = contours_[frame];
  char when[64];
  std::snprintf(when, sizeof when, "frame %d   %.2f s", set.frame_index, set.time_s);
  write(canvas_, when, {kMargin_px, kMargin_px + kTitle_px - 7}, kInk);
  draw_video(frame, picture);

  const double brow_scale = brow_right_.width / (kBrowWidth * kChartEyeDistance);
  const double mouth_scale = mouth_.width / (kMouthWidth * kChartEyeDistance);
  draw_close_up(frame, picture, brow_right_, chart_point(-kBrowX, kBrowY), brow_scale);
  draw_close_up(frame, picture, brow_left_, chart_point(kBrowX, kBrowY), brow_scale);
  draw_close_up(frame, picture, mouth_, chart_point(kMouthX, kMouthY), mouth_scale);

  const double share = (frame + 0.5) / static_cast<double>(contours_.size());
  const int x = strip_.x + static_cast<int>(share * strip_.width);
  cv::line(canvas_, {x, strip_.y - 3}, {x, strip_.br().y}, {255, 255, 255}, 1);

  std::string lost;
  for (const Feature& feature : kFeatureSchema) {
    if (set.visible(feature.name) != nullptr) continue;
    lost += (lost.empty() ? "lost: " : ", ") + spoken(feature.name);
  }
  if (!heads_[frame]) lost = "lost: the face";
  const cv::Point at(scale_.br().x + 70, scale_.y + 11);
  if (!lost.empty()) write(canvas_, lost, at, kAlarm);
  return canvas_;
}

}  // namespace zygoma
