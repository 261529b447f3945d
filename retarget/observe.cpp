#include "retarget/observe.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "src/base/check.h"

namespace zygoma {
namespace {

// How much more uncertain than a brow or a lip a contour is, and how much confidence it needs.
struct ContourTrust {
  double noise = 1.0;
  double confidence_from = 0.0;  // no evidence below,
  double confidence_to = 0.0;    // full evidence above
};
constexpr ContourTrust trust_of(int contour) {
  if (contour == kFurrowLeftContour || contour == kFurrowRightContour) return {2.0, 0.3, 0.6};
  if (contour == kChinBossContour) return {2.0, 0.0, 0.2};
  if (contour == kHairlineContour) return {4.0, 0.0, 0.2};
  if (contour == kNoseTipContour) return {2.0, 0.0, 0.2};
  return {1.0, 0.0, 0.2};
}

}  // namespace

void ObservationOptions::check() const {
  require_range("noise_px", noise_px, 0.0, 100.0);
  require_range("model_error_mm", model_error_mm, 0.0, 100.0);
}

double contour_sigma_mm(int contour,
                        double confidence,
                        double millimetre_per_px,
                        const ObservationOptions& options) {
  constexpr double kLeastSigma_mm = 1e-4;
  const ContourTrust trust = trust_of(contour);
  const double t =
      (confidence - trust.confidence_from) / (trust.confidence_to - trust.confidence_from);
  const double gate = std::clamp(t, 0.0, 1.0);
  if (confidence < kLeastConfidence || gate <= 0.0) return 0.0;
  const double noise_mm = options.noise_px * millimetre_per_px;
  const double sigma_mm = std::max(kLeastSigma_mm, std::hypot(noise_mm, options.model_error_mm));
  return trust.noise * sigma_mm / (gate * confidence);
}

FrameReading read_frame(const ObservedFrame& frame,
                        const Neutral& neutral,
                        const PerformerFrame& performer,
                        const ObservationOptions& options) {
  FrameReading result;
  result.head = fit_head_motion_robustly(neutral.contours.nodes,
                                         frame.contours.nodes,
                                         head_weights(neutral.contours, frame.contours),
                                         0.01 * performer.face_unit_px);
  result.observation.time_s = frame.time_s;
  const HeadMotion back = result.head.inverse();
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    const double confidence =
        std::min(frame.contours.confidence[index], neutral.contours.confidence[index]);
    const double sigma = contour_sigma_mm(c, confidence, performer.millimetre_per_px, options);
    result.observation.sigma_mm[index] = sigma;
    result.displacements.usable[index] = sigma > 0.0;
    if (confidence <= 0.0) continue;
    for (int k = first_node(c); k <= last_node(c); ++k) {
      const Point2 at_neutral_head = back * Point2(frame.contours.nodes.col(k));
      result.observation.mm.col(k) = performer.to_mm(at_neutral_head);
      result.displacements.mm.col(k) = result.observation.mm.col(k) - performer.neutral_mm.col(k);
    }
  }
  return result;
}

bool is_usable(const StackedContours& contours) {
  const bool brows = contours.visible(kBrowLeftContour) && contours.visible(kBrowRightContour);
  const bool mouth = contours.visible(kUpperLipContour) || contours.visible(kLowerLipContour);
  return contours.num_visible() >= 3 && (brows || mouth);
}

double driving_confidence(const StackedContours& contours) {
  const auto& c = contours.confidence;
  double least = std::max(c[kHairlineContour], c[kNoseTipContour]);
  for (int lid = 0; lid < kNumContours; ++lid) {
    if (is_eyelid(lid)) least = std::max(least, c[static_cast<std::size_t>(lid)]);
  }
  for (const int driving :
       {kBrowLeftContour, kBrowRightContour, kUpperLipContour, kChinBossContour}) {
    least = std::min(least, c[static_cast<std::size_t>(driving)]);
  }
  return least;
}

}  // namespace zygoma
