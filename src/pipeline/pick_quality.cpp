#include "src/pipeline/pick_quality.h"

#include <algorithm>
#include <cmath>

#include "src/base/check.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/stage_figures.h"

namespace zygoma {
namespace {

constexpr int kStretches = 3;
constexpr int kFramesPerStretch = 12;

// Mean time of a frame that follows another one. The jump into a stretch does not count.
double frame_ms(const FaceQuality& quality,
                const ContractionTrack& track,
                const Identity& identity,
                TissueModel tissue) {
  HeadOptions head;
  SettleOptions settle;
  quality.apply(head, tissue, settle);
  head.skin_levels = 0;
  head.albedo_size_px = 64;
  const auto anatomy = std::make_shared<const Anatomy>(make_generic_head(identity, head));
  const std::vector<Controls> controls = controls_for(track, *anatomy);
  Simulator face(anatomy, tissue, settle);
  FaceState state = face.rest();
  const auto num_frames = static_cast<int>(controls.size());
  double sum_ms = 0.0;
  int counted = 0;
  for (int stretch = 0; stretch < kStretches; ++stretch) {
    const int begin = stretch * num_frames / kStretches;
    const int end = std::min(begin + kFramesPerStretch + 1, num_frames);
    for (int k = begin; k < end; ++k) {
      const double start_ms = thread_ms();
      face.settle(controls[k], state);
      if (k == begin) continue;
      sum_ms += thread_ms() - start_ms;
      ++counted;
    }
  }
  return counted > 0 ? sum_ms / counted : 0.0;
}

// By how much a time exceeds its budget; empty where it meets it.
std::string overrun(double ms, double budget_ms) {
  const double ratio = ms / budget_ms;
  const double percent = std::round(100.0 * (ratio - 1.0));
  if (percent <= 0.0) return {};
  if (percent < 100.0) return shortest_text(percent) + " % over";
  return shortest_text(std::round(10.0 * ratio) / 10.0) + " times as long";
}

}  // namespace

QualityPick pick_for_budget(double budget_ms,
                            const ContractionTrack& track,
                            const Identity& identity,
                            const TissueModel& tissue) {
  QualityPick pick;
  for (const FaceQuality& quality : face_qualities()) {
    const double ms = frame_ms(quality, track, identity, tissue);
    const bool quickest = &quality == &face_qualities().front();
    if (ms <= budget_ms || quickest) pick = {quality, ms};
    if (ms > budget_ms) break;
  }
  return pick;
}

QualityPick pick_for_tolerance(double tolerance_mm) {
  for (const FaceQuality& quality : face_qualities()) {
    if (quality.expected_rms_mm <= tolerance_mm) return {quality, 0.0};
  }
  return {face_qualities().back(), 0.0};
}

std::string budget_forecast(double expected_ms, double budget_ms) {
  const std::string over = overrun(expected_ms, budget_ms);
  if (over.empty()) return {};
  return "the budget of " + shortest_text(budget_ms) + " ms probably cannot be met, " + over;
}

std::string budget_verdict(double took_ms, double budget_ms) {
  const std::string over = overrun(took_ms, budget_ms);
  return "the budget is " + shortest_text(budget_ms) +
         " ms: " + (over.empty() ? "met" : "not met, " + over);
}

}  // namespace zygoma
