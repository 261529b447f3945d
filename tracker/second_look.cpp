#include "tracker/second_look.h"

#include <algorithm>
#include <utility>

#include "src/base/check.h"
#include "tracker/face_chart.h"

namespace zygoma {
namespace {

constexpr double kRamp = 6.0;  // frames

// Weight of the backward track at `place` of `count` frames.
double backward_weight(size_t place, size_t count, bool first_stretch) {
  const auto from_start = static_cast<double>(place);
  const auto from_end = static_cast<double>(count - 1 - place);
  if (first_stretch) return from_end / static_cast<double>(count - 1);
  return 0.5 * std::min({1.0, (from_start + 1.0) / kRamp, from_end / kRamp});
}

void blend(const Contour& back, double weight, double tolerance_px, Contour& contour) {
  if (back.lost()) return;
  if (contour.lost()) {
    contour = back;
    return;
  }
  double apart_px = 0.0;
  for (size_t i = 0; i < back.points_px.size(); ++i) {
    Point2& p = contour.points_px[i];
    const Point2 step = back.points_px[i] - p;
    apart_px += step.norm() / static_cast<double>(back.points_px.size());
    p += weight * step;
  }
  contour.confidence += weight * (back.confidence - contour.confidence);
  const double doubt = apart_px / tolerance_px;
  contour.confidence /= 1.0 + doubt * doubt;
}

}  // namespace

void SecondLookOptions::check() const {
  require_range("second look: num_frames", num_frames, 2, 1000);
  require(tolerance_iod > 0.0, "second look: tolerance_iod must be > 0");
}

SecondLook::SecondLook(const SecondLookOptions& options)
    : options_(options), first_stretch_(!options.start_is_given) {
  options_.check();
}

void SecondLook::add(const Frame& frame) {
  frames_.push_back(frame);
  frames_.back().image = frame.image.clone();  // of which the caller may make the next one
}

bool SecondLook::full() const {
  if (frames_.empty()) return false;
  const Frame& frame = frames_.back();
  const size_t bytes = frames_.size() * (frame.image.total() * frame.image.elemSize() +
                                         frame.planes.y.total() + 2 * frame.planes.cb.total());
  return frames_.size() >= static_cast<size_t>(options_.num_frames) ||
         bytes >= options_.memory_bytes;
}

void SecondLook::look(const Tracker& tracker,
                      std::vector<ContourSet>& contours,
                      std::vector<std::optional<Similarity>>& heads) {
  const std::vector<Frame> frames = std::exchange(frames_, {});
  const bool first = std::exchange(first_stretch_, false);
  if (frames.size() < 2 || tracker.head() == nullptr) return;
  Tracker back = tracker.looking_back();
  for (size_t i = frames.size() - 1; i-- > 0;) {
    const ContourSet seen = back.track(frames[i]);
    if (!back.report().face_found || back.report().started) return;
    const size_t at = contours.size() - frames.size() + i;
    const double weight = backward_weight(i, frames.size(), first);
    const double tolerance_px = options_.tolerance_iod * kChartEyeDistance * back.head()->scale();
    // Sums round alike in a clip and in its mirror image only in the way round both are looked at.
    const Mirror& mirror = back.mirror();
    const int width = Picture(frames[i]).size().width;
    const ContourSet turned = mirror.of(seen, width);
    ContourSet blended = mirror.of(std::move(contours[at]), width);
    for (size_t c = 0; c < turned.contours.size(); ++c) {
      blend(turned.contours[c], weight, tolerance_px, blended.contours[c]);
    }
    contours[at] = mirror.of(std::move(blended), width);
    if (!heads[at]) heads[at] = *back.head();
  }
}

}  // namespace zygoma
