#include "src/pipeline/overlay.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "src/base/names.h"

namespace zygoma {
namespace {

constexpr int kSubPixelShift = 4;  // cv::polylines takes fixed-point coordinates

// Viridis, from 0 to 1 in 256 steps.
cv::Mat colour_scale() {
  cv::Mat steps(1, 256, CV_8UC1);
  for (int i = 0; i < 256; ++i) steps.at<unsigned char>(0, i) = static_cast<unsigned char>(i);
  cv::Mat colours;
  cv::applyColorMap(steps, colours, cv::COLORMAP_VIRIDIS);
  return colours;
}

cv::Scalar rim_of(const cv::Scalar& colour) {
  const double luminance = 0.07 * colour[0] + 0.72 * colour[1] + 0.21 * colour[2];
  return luminance > 60.0 ? cv::Scalar(25, 22, 20) : cv::Scalar(205, 205, 205);
}

cv::Point fixed_point(const Point2& p) {
  constexpr double kUnit = 1 << kSubPixelShift;
  return {static_cast<int>(std::lround(p.x() * kUnit)),
          static_cast<int>(std::lround(p.y() * kUnit))};
}

// "occipitofrontalis_inner_L" -> "occipitofrontalis inner": the pair's name, or nothing for _R.
std::string pair_name(const std::string& muscle) {
  if (!muscle.ends_with("_L")) return {};
  std::string name = muscle.substr(0, muscle.size() - 2);
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

// Long anatomical names do not fit beside a face; the shortening keeps them recognisable.
std::string short_name(std::string name) {
  const std::pair<const char*, const char*> shorter[] = {
      {"occipitofrontalis", "frontalis"},
      {"levator labii superioris alaeque nasi", "levator al. nasi"},
      {"levator labii superioris", "levator labii"},
      {"depressor anguli oris", "depr. anguli"},
      {"depressor labii inferioris", "depr. labii"},
      {"corrugator supercilii", "corrugator"},
      {"zygomaticus", "zygomatic"},
      {"incisivus labii superioris", "incisivus sup."},
      {"incisivus labii inferioris", "incisivus inf."},
      {"levator palpebrae superioris", "levator palpebrae"},
      {"orbicularis", "orbic."},
      {"marginal superior", "marg. sup."},
      {"marginal inferior", "marg. inf."},
  };
  for (const auto& [from, to] : shorter) {
    const std::size_t at = name.find(from);
    if (at != std::string::npos) name.replace(at, std::string(from).size(), to);
  }
  return name;
}

}  // namespace

cv::Scalar confidence_colour(double confidence) {
  static const cv::Mat scale = colour_scale();
  const int step = static_cast<int>(std::lround(255.0 * std::clamp(confidence, 0.0, 1.0)));
  const auto& colour = scale.at<cv::Vec3b>(0, step);
  return {static_cast<double>(colour[0]),
          static_cast<double>(colour[1]),
          static_cast<double>(colour[2])};
}

void draw_contours(const ContourSet& contours,
                   const Similarity& canvas_from_image,
                   const ContourStyle& style,
                   cv::Mat& bgr) {
  std::vector<cv::Point> line;
  for (const Contour& contour : contours.contours) {
    if (contour.lost()) continue;
    line.clear();
    for (const Point2& p : contour.points_px) {
      line.push_back(fixed_point(canvas_from_image.apply(p)));
    }
    const cv::Scalar colour = confidence_colour(contour.confidence);
    const cv::Scalar rim = rim_of(colour);
    const auto stroke = [&](const cv::Scalar& ink, int width_px, int dot_px) {
      cv::polylines(bgr, line, false, ink, width_px, cv::LINE_AA, kSubPixelShift);
      if (!style.nodes) return;
      for (const cv::Point& p : line) {
        cv::circle(bgr, p, dot_px << kSubPixelShift, ink, cv::FILLED, cv::LINE_AA, kSubPixelShift);
      }
    };
    stroke(rim, style.width_px + 1, style.width_px + 2);
    stroke(colour, style.width_px, style.width_px + 1);
  }
}

Similarity enlargement(double scale) { return {scale, 0.0, Point2::Constant(0.5 * (scale - 1.0))}; }

ContractionBars::ContractionBars(const std::vector<std::string>& muscles, cv::Size size_px)
    : num_muscles_(muscles.size()), background_(size_px, CV_8UC3, cv::Scalar(38, 35, 32)) {
  if (background_.empty()) return;
  std::vector<std::pair<std::string, int>> rows;  // pair name, index of the left muscle
  for (std::size_t i = 0; i < muscles.size(); ++i) {
    if (const std::string name = pair_name(muscles[i]); !name.empty()) {
      rows.emplace_back(name, static_cast<int>(i));
    }
  }
  const int num_rows = static_cast<int>(rows.size()) + 2;  // a head line above, the jaw below
  const double row_px = static_cast<double>(size_px.height) / num_rows;
  const double font = std::clamp(row_px / 62.0, 0.3, 0.6);
  const int margin = 8;
  const int half = (size_px.width - 3 * margin) / 2;
  const int bar_px = std::max(3, static_cast<int>(row_px * 0.25));
  const auto label = [&](const std::string& text, int x, double y) {
    cv::putText(background_,
                text,
                {x, static_cast<int>(y)},
                cv::FONT_HERSHEY_SIMPLEX,
                font,
                {210, 208, 205},
                1,
                cv::LINE_AA);
  };
  const auto add_bar = [&](int x, double row_y, int width, int muscle) {
    const cv::Rect box(x, static_cast<int>(row_y + row_px * 0.56), width, bar_px);
    cv::rectangle(background_, box, {70, 66, 62}, cv::FILLED);
    bars_.push_back({box, muscle});
  };

  // The subject's right side is drawn on the left, as it is seen in the picture beside.
  label("right", margin, row_px * 0.7);
  label("left", 2 * margin + half, row_px * 0.7);
  double y = row_px;
  for (const auto& [name, left] : rows) {
    label(short_name(name), margin, y + row_px * 0.42);
    const std::string twin = muscles[left].substr(0, muscles[left].size() - 1) + "R";
    const int right = find_name(muscles, twin);
    if (right >= 0) add_bar(margin, y, half, right);
    add_bar(2 * margin + half, y, half, left);
    y += row_px;
  }
  label("jaw", margin, y + row_px * 0.42);
  add_bar(margin, y, size_px.width - 2 * margin, -1);
}

void ContractionBars::draw(const Contractions& contractions, cv::Mat& bgr) const {
  background_.copyTo(bgr);
  if (contractions.value.size() != num_muscles_) return;  // nothing known of this frame
  for (const Bar& bar : bars_) {
    const double value = bar.muscle < 0 ? contractions.jaw : contractions.value[bar.muscle];
    cv::Rect filled = bar.box;
    filled.width = static_cast<int>(std::lround(bar.box.width * std::clamp(value, 0.0, 1.0)));
    if (filled.width > 0) cv::rectangle(bgr, filled, {120, 190, 245}, cv::FILLED);
  }
}

}  // namespace zygoma
