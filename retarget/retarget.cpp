#include "retarget/retarget.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "retarget/calibration.h"
#include "retarget/estimate.h"
#include "retarget/head_motion.h"
#include "retarget/refine.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Noise of a tracked contour across itself, and how far one person's skin moves unlike another's.
constexpr double kNoise_px = 0.5;
constexpr double kModelError_mm = 0.4;
constexpr double kLeastConfidence = 0.1;  // below: as good as lost
constexpr double kFastest_per_s = 6.0;    // change of a contraction, one sigma
constexpr double kLeastTimeSigma = 0.04;

// How much more uncertain than a brow or a lip a contour is, and how much confidence it needs.
struct ContourTrust {
  double noise = 1.0;
  double confidence_from = 0.0;  // no evidence below,
  double confidence_to = 0.0;    // full evidence above
};
constexpr ContourTrust trust_of(int contour) {
  if (contour == kFurrowLeftContour || contour == kFurrowRightContour) return {2.0, 0.3, 0.6};
  if (contour == kChinBossContour) return {2.0, 0.0, 0.2};
  if (contour == kHairlineContour) return {2.0, 0.0, 0.2};
  return {1.0, 0.0, 0.2};
}

double contour_sigma_mm(int contour, double confidence, double millimetre_per_px) {
  const ContourTrust trust = trust_of(contour);
  const double t =
      (confidence - trust.confidence_from) / (trust.confidence_to - trust.confidence_from);
  const double gate = std::clamp(t, 0.0, 1.0);
  if (confidence < kLeastConfidence || gate <= 0.0) return 0.0;
  const double noise_mm = kNoise_px * millimetre_per_px;
  return trust.noise * std::hypot(noise_mm, kModelError_mm) / (gate * confidence);
}

bool is_usable(const StackedContours& contours) {
  const bool brows = contours.visible(kBrowLeftContour) && contours.visible(kBrowRightContour);
  const bool mouth = contours.visible(kUpperLipContour) || contours.visible(kLowerLipContour);
  return contours.num_visible() >= 3 && (brows || mouth);
}

double driving_confidence(const StackedContours& contours) {
  const auto& c = contours.confidence;
  double least = std::max(c[kHairlineContour], c[kNoseTipContour]);
  for (const int driving :
       {kBrowLeftContour, kBrowRightContour, kUpperLipContour, kChinBossContour}) {
    least = std::min(least, c[static_cast<std::size_t>(driving)]);
  }
  return least;
}

// A frame in the performer's head frame.
struct HeadFreeFrame {
  HeadMotion head;  // neutral px to frame px, from the rigid contours
  FrameObservation observation;
  Displacements displacements;
};

HeadFreeFrame remove_head(const ObservedFrame& frame,
                          const Neutral& neutral,
                          const PerformerFrame& performer) {
  HeadFreeFrame result;
  result.head = fit_head_motion_robustly(neutral.contours.nodes,
                                         frame.contours.nodes,
                                         head_weights(neutral.contours, frame.contours),
                                         0.01 * performer.face_unit_px);
  const HeadMotion back = result.head.inverse();
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    const double confidence =
        std::min(frame.contours.confidence[index], neutral.contours.confidence[index]);
    const double sigma = contour_sigma_mm(c, confidence, performer.millimetre_per_px);
    result.observation.sigma_mm[index] = sigma;
    result.displacements.usable[index] = sigma > 0.0;
    if (confidence <= 0.0) continue;
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      const Point2 at_neutral_head = back * Point2(frame.contours.nodes.col(k));
      result.observation.mm.col(k) = performer.to_mm(at_neutral_head);
      result.displacements.mm.col(k) = result.observation.mm.col(k) - performer.neutral_mm.col(k);
    }
  }
  return result;
}

// The state of one frame between the passes.
struct FrameEstimate {
  double time_s = 0.0;
  HeadFreeFrame frame;
  RefinedFrame refined;
};

double time_sigma(double step_s) {
  return std::max(kLeastTimeSigma, kFastest_per_s * std::abs(step_s));
}

// Causal belief: the controls have not gone far since the last estimate.
ControlPrior from_the_past(const std::vector<FrameEstimate>& done, double time_s) {
  if (done.empty()) return {{}, kInfinite};
  return {done.back().refined.controls, time_sigma(time_s - done.back().time_s)};
}

// Belief without lag: the straight line between the neighbours' first estimates.
ControlPrior from_both_sides(const std::vector<FrameEstimate>& estimates, std::size_t t) {
  if (estimates.size() < 3) return {{}, kInfinite};
  if (t == 0 || t + 1 == estimates.size()) {
    const std::size_t other = t == 0 ? 1 : t - 1;
    return {estimates[other].refined.controls,
            time_sigma(estimates[t].time_s - estimates[other].time_s)};
  }
  const FrameEstimate& before = estimates[t - 1];
  const FrameEstimate& after = estimates[t + 1];
  const double gap = after.time_s - before.time_s;
  const double share =
      gap > 0.0 ? std::clamp((estimates[t].time_s - before.time_s) / gap, 0.0, 1.0) : 0.5;
  return {(1.0 - share) * before.refined.controls + share * after.refined.controls,
          time_sigma(0.5 * gap)};
}

HeadPose head_pose(const FrameEstimate& estimate,
                   const PerformerFrame& performer,
                   const Point2& reference_mm) {
  const HeadMotion& correction = estimate.refined.head;
  const Point2 at = estimate.frame.head * performer.to_px(correction.inverse() * reference_mm);
  HeadPose pose;
  pose.x_px = at.x();
  pose.y_px = at.y();
  pose.scale = estimate.frame.head.scale() / correction.scale();
  pose.roll_rad = estimate.frame.head.roll_rad() - correction.roll_rad();
  return pose;
}

void write_estimate(const FrameEstimate& estimate,
                    const StackedContours& seen,
                    const PerformerFrame& performer,
                    const Point2& reference_mm,
                    Contractions& out) {
  const RefinedFrame& refined = estimate.refined;
  const Eigen::Index n = refined.controls.size() - 1;
  out.value.assign(refined.controls.data(), refined.controls.data() + n);
  out.jaw = refined.controls[n];
  if (refined.sigma.size() > 0) {
    out.sigma.assign(refined.sigma.data(), refined.sigma.data() + n);
    out.jaw_sigma = refined.sigma[n];
  }
  out.head = head_pose(estimate, performer, reference_mm);
  out.confidence = driving_confidence(seen);
  out.success = out.confidence >= kLeastConfidence;
  const double px_per_mm = out.head.scale / performer.millimetre_per_px;
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    if (estimate.frame.observation.sigma_mm[index] <= 0.0) continue;
    out.residual_px.emplace_back(std::string(kFeatureSchema[index].name),
                                 refined.residual_mm[index] * px_per_mm);
  }
}

// The closed form dressed as a refined frame: no sigma, residuals against the model all the same.
RefinedFrame closed_form_alone(const HeadFreeFrame& frame,
                               const FaceResponse& face,
                               const Eigen::VectorXd& controls) {
  RefinedFrame result;
  result.controls = controls;
  result.converged = true;
  for (int c = 0; c < kNumContours; ++c) {
    double sum = 0.0;
    for (int k = node_begin(c); k < node_begin(c + 1); ++k) {
      const Point2 misfit = frame.displacements.mm.col(k) - face.displacement(k, controls.data());
      sum += misfit.squaredNorm();
    }
    result.residual_mm[static_cast<std::size_t>(c)] = std::sqrt(sum / num_nodes(c));
  }
  return result;
}

Point2 head_reference_mm(const Neutral& neutral, const PerformerFrame& performer) {
  const int contour =
      neutral.contours.visible(kHairlineContour) ? kHairlineContour : kNoseTipContour;
  return performer.to_mm(neutral.contours.mean(contour));
}

double median_residual(const ContractionTrack& track) {
  std::vector<double> all;
  for (const Contractions& frame : track.frames) {
    for (const auto& [name, residual] : frame.residual_px) all.push_back(residual);
  }
  if (all.empty()) return 0.0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

}  // namespace

void RetargetOptions::check() const {
  require(neutral_frame >= -1,
          "neutral_frame is " + std::to_string(neutral_frame) +
              "; expected a frame number, or -1 to have it found");
}

ContractionTrack retarget(const std::vector<ContourSet>& contours,
                          const FaceResponse& face,
                          const RetargetOptions& options,
                          RetargetReport& report,
                          const StopQuestion& stop) {
  options.check();
  report = {};
  report.response_not_converged = face.settles_not_converged;
  ContractionTrack track;
  track.muscles = face.muscles;

  std::vector<ObservedFrame> observed;
  std::vector<std::size_t> source;
  for (std::size_t t = 0; t < contours.size(); ++t) {
    const ObservedFrame frame{
        contours[t].frame_index, contours[t].time_s, stack_contours(contours[t])};
    if (!is_usable(frame.contours)) continue;
    observed.push_back(frame);
    source.push_back(t);
  }
  const Neutral neutral = find_neutral(observed, options.neutral_frame);
  const PerformerFrame performer = measure_performer(neutral, face);
  Refiner refiner(face, performer.neutral_mm);

  // First pass, causal: head frame out, the paper's estimates, refinement from there.
  std::vector<FrameEstimate> estimates;
  for (const ObservedFrame& frame : observed) {
    if (stop && stop()) break;
    FrameEstimate estimate;
    estimate.time_s = frame.time_s;
    estimate.frame = remove_head(frame, neutral, performer);
    const Eigen::VectorXd* last = estimates.empty() ? nullptr : &estimates.back().refined.controls;
    const Eigen::VectorXd guess = estimate_controls(estimate.frame.displacements, face, last);
    estimate.refined = options.refine ? refiner.refine(estimate.frame.observation,
                                                       guess,
                                                       from_the_past(estimates, frame.time_s))
                                      : closed_form_alone(estimate.frame, face, guess);
    estimates.push_back(std::move(estimate));
  }

  // Second pass: every frame again, now leaning on both neighbours, so that nothing lags.
  std::vector<RefinedFrame> smooth;
  for (std::size_t t = 0; options.refine && t < estimates.size(); ++t) {
    if (stop && stop()) break;
    smooth.push_back(refiner.refine(estimates[t].frame.observation,
                                    estimates[t].refined.controls,
                                    from_both_sides(estimates, t)));
  }
  for (std::size_t t = 0; t < smooth.size(); ++t) estimates[t].refined = smooth[t];

  const std::size_t num_frames =
      estimates.size() == observed.size()
          ? contours.size()
          : source[estimates.size()];  // stopped: up to the first frame not done
  const Point2 reference_mm = head_reference_mm(neutral, performer);
  for (std::size_t t = 0, next = 0; t < num_frames; ++t) {
    Contractions out;
    out.frame_index = contours[t].frame_index;
    out.time_s = contours[t].time_s;
    if (next < estimates.size() && source[next] == t) {
      const FrameEstimate& estimate = estimates[next];
      write_estimate(estimate, observed[next].contours, performer, reference_mm, out);
      if (!estimate.refined.converged) ++report.frames_not_converged;
      ++report.frames_estimated;
      ++next;
    }
    track.frames.push_back(std::move(out));
  }
  report.neutral_frame = neutral.frame_index;
  report.face_unit_px = performer.face_unit_px;
  report.millimetre_per_px = performer.millimetre_per_px;
  report.median_residual_px = median_residual(track);
  return track;
}

}  // namespace zygoma
