#include "retarget/estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "retarget/jaw_carry.h"

namespace zygoma {
namespace {

// A muscle whose posterior is this close to its prior was not seen.
constexpr double kObservedShare = 0.33;
constexpr double kLeastTimeSigma = 0.04;
// Contours are weighted pessimistically, so that no estimate leans on one too far. Measured on
// synthetic performers, errors are this share of what the posterior then says; evidence counts
// accordingly more in the sigma that is reported, the priors do not.
constexpr double kErrorShare = 0.6;

Point2 reference_of(const Neutral& neutral, const PerformerFrame& performer) {
  const int contour =
      neutral.contours.visible(kHairlineContour) ? kHairlineContour : kNoseTipContour;
  return performer.to_mm(neutral.contours.mean(contour));
}

HeadPose head_pose(const FrameEstimate& estimate, const Calibration& calibration) {
  const HeadMotion more = similarity_of(estimate.refined.head);
  const HeadMotion& guess = estimate.reading.head;
  const Point2 at = guess * calibration.performer.to_px(more * calibration.head_reference_mm);
  HeadPose pose;
  pose.x_px = at.x();
  pose.y_px = at.y();
  pose.scale = guess.scale() * more.scale();
  pose.roll_rad = guess.roll_rad() + more.roll_rad();
  return pose;
}

// A camera of unknown focal length is as far away as that of the response.
double inverse_distance_per_mm(const Calibration& calibration, const RetargetOptions& options) {
  const double focal_mm = options.focal_length_px * calibration.performer.millimetre_per_px;
  return 1.0 / (focal_mm > 0.0 ? focal_mm : calibration.response.viewing_distance_mm);
}

}  // namespace

Calibration calibrate(const Neutral& neutral,
                      const Eigen::VectorXd& gain,
                      const FaceResponse& response,
                      FaceLevel level) {
  Calibration result;
  result.neutral = neutral;
  result.performer = measure_performer(neutral, response);
  result.gain = gain;
  result.model = (level == FaceLevel::kLinear ? response.linearised() : response).scaled(gain);
  result.response = result.model;
  result.head_reference_mm = reference_of(neutral, result.performer);
  return result;
}

Calibration learn(const Calibration& calibration,
                  std::span<const FrameEstimate> sample,
                  const RetargetOptions& options) {
  FrameScene scene(calibration.response,
                   calibration.performer.neutral_mm,
                   inverse_distance_per_mm(calibration, options),
                   options.refinement);
  std::vector<FrameObservation> frames;
  std::vector<RefinedFrame> solved;
  for (const FrameEstimate& estimate : sample) {
    frames.push_back(estimate.reading.observation);
    solved.push_back(estimate.refined);
  }
  Calibration result = calibration;
  result.jaw_carry =
      learn_jaw_carry(calibration.model, calibration.jaw_carry, scene, frames, solved);
  result.response = with_jaw_carry(calibration.model, result.jaw_carry);
  return result;
}

FrameEstimator::FrameEstimator(const Calibration& calibration,
                               const RetargetOptions& options,
                               Simulator* lattice)
    : calibration_(calibration),
      options_(options),
      refiner_(calibration.response,
               calibration.performer.neutral_mm,
               inverse_distance_per_mm(calibration, options),
               options.refinement) {
  if (!options.causal) {
    RefineOptions rough = options.refinement;
    rough.tolerance = std::max(1e-2, rough.tolerance);
    first_pass_ = std::make_unique<Refiner>(calibration.response,
                                            calibration.performer.neutral_mm,
                                            inverse_distance_per_mm(calibration, options),
                                            rough);
  }
  if (options.level == FaceLevel::kLattice && lattice != nullptr) {
    loop_ = std::make_unique<LatticeLoop>(
        *lattice, calibration.model, calibration.gain, options.lattice_loop);
  }
}

FrameEstimate FrameEstimator::next(const ObservedFrame& frame) {
  FrameEstimate estimate;
  estimate.seen = frame.contours;
  estimate.reading =
      read_frame(frame, calibration_.neutral, calibration_.performer, options_.observation);
  RefinedFrame guess;
  guess.controls = estimate_controls(
      estimate.reading.displacements, calibration_.response, has_last_ ? &last_.controls : nullptr);
  ControlPrior time{{}, std::numeric_limits<double>::infinity()};
  if (has_last_) {
    const double step_s = std::abs(frame.time_s - last_time_s_);
    time = {last_.controls, std::max(kLeastTimeSigma, options_.refinement.fastest_per_s * step_s)};
    estimate.correction = last_correction_;
    // Yesterday's answer is the better start where the paper's rules say nothing.
    if (options_.refine) guess.controls = last_.controls;
  }
  if (options_.refine) {
    estimate.refined = refine(estimate, guess, time);
  } else {
    estimate.refined = guess;
    estimate.refined.converged = true;
  }
  last_ = estimate.refined;
  last_time_s_ = frame.time_s;
  last_correction_ = estimate.correction;
  has_last_ = true;
  return estimate;
}

RefinedFrame FrameEstimator::refine(FrameEstimate& estimate,
                                    const RefinedFrame& start,
                                    const ControlPrior& time) {
  FrameObservation& seen = estimate.reading.observation;
  const auto solve = [&](const RefinedFrame& from) {
    seen.correction = estimate.correction.at.size() > 0 ? &estimate.correction : nullptr;
    Refiner& refiner = first_pass_ == nullptr ? refiner_ : *first_pass_;
    const RefinedFrame solved = refiner.refine(seen, from, time);
    seen.correction = nullptr;
    return solved;
  };
  RefinedFrame result = solve(start);
  if (loop_ == nullptr) return result;
  for (int round = 0; round < options_.lattice_loop.max_rounds; ++round) {
    if (!loop_->has_moved(estimate.correction, result.controls)) return result;
    if (!loop_->correct(result.controls, estimate.correction)) break;
    result = solve(result);
  }
  if (loop_->has_moved(estimate.correction, result.controls)) result.converged = false;
  return result;
}

void FrameEstimator::improve(std::span<FrameEstimate> estimates, int num_fixed) {
  const int rounds = loop_ == nullptr ? 1 : options_.lattice_loop.max_rounds;
  for (int round = 0; round < rounds; ++round) {
    std::vector<FrameObservation> frames;
    std::vector<RefinedFrame> solved;
    for (FrameEstimate& estimate : estimates) {
      frames.push_back(estimate.reading.observation);
      if (estimate.correction.at.size() > 0) frames.back().correction = &estimate.correction;
      solved.push_back(estimate.refined);
    }
    refiner_.refine_window(frames, solved, num_fixed);
    bool moved = false;
    for (std::size_t t = 0; t < estimates.size(); ++t) {
      estimates[t].refined = solved[t];
      if (loop_ == nullptr || static_cast<int>(t) < num_fixed) continue;
      if (!loop_->has_moved(estimates[t].correction, solved[t].controls)) continue;
      moved = loop_->correct(solved[t].controls, estimates[t].correction) || moved;
      if (round + 1 == rounds) estimates[t].refined.converged = false;
    }
    if (!moved) break;
  }
}

void FrameEstimator::judge(FrameEstimate& estimate) {
  FrameObservation& seen = estimate.reading.observation;
  seen.correction = estimate.correction.at.size() > 0 ? &estimate.correction : nullptr;
  estimate.posterior = refiner_.posterior(seen, estimate.refined);
  seen.correction = nullptr;
  Eigen::VectorXd& sigma = estimate.posterior.sigma;
  const Eigen::ArrayXd prior = estimate.posterior.prior_sigma.array().square().inverse();
  const Eigen::ArrayXd evidence =
      (sigma.array().square().inverse() - prior).max(0.0) / (kErrorShare * kErrorShare);
  sigma = (prior + evidence).sqrt().inverse().matrix();
}

LatticeLoopFigures FrameEstimator::lattice_figures() const {
  return loop_ == nullptr ? LatticeLoopFigures{} : loop_->figures();
}

Contractions contractions_of(const FrameEstimate& estimate, const Calibration& calibration) {
  const RefinedFrame& refined = estimate.refined;
  const FramePosterior& posterior = estimate.posterior;
  const Eigen::Index n = refined.controls.size() - 1;
  Contractions out;
  out.value.assign(refined.controls.data(), refined.controls.data() + n);
  out.jaw = refined.controls[n];
  if (posterior.sigma.size() > 0) {
    out.sigma.assign(posterior.sigma.data(), posterior.sigma.data() + n);
    out.jaw_sigma = posterior.sigma[n];
    const auto seen = [&](Eigen::Index i) {
      return posterior.sigma[i] < kObservedShare * posterior.prior_sigma[i];
    };
    for (Eigen::Index i = 0; i < n; ++i) out.observed.push_back(seen(i));
    out.jaw_observed = seen(n);
  }
  out.head = head_pose(estimate, calibration);
  out.confidence = driving_confidence(estimate.seen);
  out.success = out.confidence >= kLeastConfidence;
  const double px_per_mm = out.head.scale / calibration.performer.millimetre_per_px;
  for (int c = 0; c < kNumContours; ++c) {
    const auto index = static_cast<std::size_t>(c);
    if (estimate.reading.observation.sigma_mm[index] <= 0.0 || is_eyelid(c)) continue;
    out.residual_px.emplace_back(std::string(kFeatureSchema[index].name),
                                 posterior.residual_mm[index] * px_per_mm);
  }
  return out;
}

void carry_sigma(std::span<FrameEstimate> estimates,
                 const Eigen::VectorXd& fastest_per_s,
                 bool causal) {
  const auto lend = [&](const FrameEstimate& from, FrameEstimate& to) {
    const double step_s = std::abs(to.reading.observation.time_s - from.reading.observation.time_s);
    // A random walk: variances of the changes add up.
    const Eigen::ArrayXd change = fastest_per_s.array() * step_s;
    to.posterior.sigma = to.posterior.sigma.cwiseMin(
        (from.posterior.sigma.array().square() + change.square()).sqrt().matrix());
  };
  for (std::size_t t = 1; t < estimates.size(); ++t) lend(estimates[t - 1], estimates[t]);
  for (std::size_t t = estimates.size(); !causal && t-- > 1;) lend(estimates[t], estimates[t - 1]);
}

}  // namespace zygoma
