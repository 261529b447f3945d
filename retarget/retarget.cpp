#include "retarget/retarget.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "retarget/calibration.h"
#include "retarget/estimator.h"
#include "src/base/check.h"

namespace zygoma {
namespace {

// The frames of a clip that show enough of a face, and where they stand in it.
struct UsableFrames {
  std::vector<ObservedFrame> frames;
  std::vector<std::size_t> source;
};

UsableFrames usable_frames(const std::vector<ContourSet>& contours) {
  UsableFrames usable;
  for (std::size_t t = 0; t < contours.size(); ++t) {
    const ObservedFrame frame{
        contours[t].frame_index, contours[t].time_s, stack_contours(contours[t])};
    if (!is_usable(frame.contours)) continue;
    usable.frames.push_back(frame);
    usable.source.push_back(t);
  }
  return usable;
}

// Every so many frames of an even sample of a clip.
enum class SampleSize { kFew = 3, kAll = 1 };

// Frames from all over the clip, every one for itself and with little patience: to compare neutrals
// and to learn from.
std::vector<FrameEstimate> estimate_sample(const std::vector<ObservedFrame>& frames,
                                           const Calibration& calibration,
                                           RetargetOptions options,
                                           SampleSize size) {
  constexpr std::size_t kSample = 16;
  options.refinement.fastest_per_s = 1e6;
  options.refinement.max_iterations = std::min(8, options.refinement.max_iterations);
  options.level = std::min(options.level, FaceLevel::kCorrected);
  options.refine = true;
  options.causal = true;
  FrameEstimator estimator(calibration, options, nullptr);
  const std::size_t count = std::min(kSample, frames.size());
  std::vector<FrameEstimate> sample;
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(size)) {
    sample.push_back(estimator.next(frames[(2 * i + 1) * frames.size() / (2 * count)]));
  }
  return sample;
}

double unexplained(const std::vector<FrameEstimate>& sample) {
  double sum = 0.0;
  for (const FrameEstimate& estimate : sample) sum += estimate.refined.cost;
  return sum / static_cast<double>(sample.size());
}

// A face that may be at rest, what the clip looks like from there, and how little it convinces.
struct Candidate {
  Calibration calibration;
  std::vector<FrameEstimate> sample;
  double doubt = 0.0;
};

// What the model cannot explain is evidence and counts twice; the rest are rules of thumb.
double doubt_of(const Candidate& candidate, const FaceResponse& face) {
  constexpr double kClearlyNotAtRest = 0.05;  // face sizes
  constexpr int kFewestStill = 3;
  constexpr double kMoving = 2.0;
  constexpr double kDoubted = 0.5;  // per reason
  const Neutral& neutral = candidate.calibration.neutral;
  const double left = unexplained(candidate.sample);
  return left * left * (1.0 + std::max(0.0, neutral.score) / kClearlyNotAtRest) *
         (neutral.num_frames < kFewestStill ? kMoving : 1.0) *
         (1.0 + kDoubted * static_cast<double>(doubts_about(neutral, face).size()));
}

// Of the likely neutrals the one that is both at rest and explains the clip: of many by a few
// frames, of the best of those by more.
Candidate choose_neutral(const std::vector<ObservedFrame>& frames,
                         const FaceResponse& face,
                         const Eigen::VectorXd& gain,
                         const RetargetOptions& options) {
  constexpr int kCandidates = 16;
  constexpr std::size_t kFinalists = 3;
  std::vector<Candidate> candidates;
  const auto judge = [&](Candidate& candidate, SampleSize size) {
    candidate.sample = estimate_sample(frames, candidate.calibration, options, size);
    candidate.doubt = doubt_of(candidate, face);
  };
  const auto sort = [&] {
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
      return a.doubt < b.doubt;
    });
  };
  if (options.neutral_frame >= 0) {
    candidates.push_back(
        {calibrate(neutral_at(frames, options.neutral_frame), gain, face, options.level), {}, 0.0});
    judge(candidates.front(), SampleSize::kAll);
    return std::move(candidates.front());
  }
  for (const Neutral& neutral : neutral_candidates(frames, kCandidates)) {
    candidates.push_back({calibrate(neutral, gain, face, options.level), {}, 0.0});
    judge(candidates.back(), SampleSize::kFew);
  }
  sort();
  candidates.resize(std::min(kFinalists, candidates.size()));
  for (Candidate& candidate : candidates) judge(candidate, SampleSize::kAll);
  sort();
  return std::move(candidates.front());
}

// The performer at rest: from the clip, unless a profile knows better and no frame was named.
Calibration calibrate_clip(const std::vector<ObservedFrame>& frames,
                           const FaceModel& face,
                           const RetargetOptions& options,
                           RetargetReport& report) {
  const PerformerProfile* profile = face.profile;
  const Eigen::VectorXd gain = profile == nullptr
                                   ? Eigen::VectorXd::Ones(face.response.num_controls()).eval()
                                   : range_gain(*profile, face.response);
  Candidate chosen = choose_neutral(frames, face.response, gain, options);
  report.neutral_frame = chosen.calibration.neutral.frame_index;
  if (profile != nullptr) {
    report.profile_difference =
        proportion_difference(face_proportions(chosen.calibration.neutral.contours),
                              face_proportions(profile->neutral.contours));
  }
  if (profile != nullptr && options.neutral_frame < 0) {
    report.neutral_frame = -1;
    chosen.calibration = calibrate(profile->neutral, gain, face.response, options.level);
    chosen.sample = estimate_sample(frames, chosen.calibration, options, SampleSize::kAll);
  }
  report.neutral_doubts = doubts_about(chosen.calibration.neutral, face.response);
  if (!options.refine) return chosen.calibration;  // the paper's estimates know no performer
  const Calibration better = learn(chosen.calibration, chosen.sample, options);
  return learn(better, estimate_sample(frames, better, options, SampleSize::kAll), options);
}

// Whether to stop with this frame of a pass over all of them.
struct PassQuestion {
  const RetargetQuestion& stop;
  int pass = 0;
  int num_passes = 1;

  bool operator()(std::size_t frame, std::size_t num_frames) const {
    const double done = static_cast<double>(frame) / static_cast<double>(num_frames);
    return stop && stop((pass + done) / num_passes);
  }
};

// Every frame in turn, leaning on the one before.
std::vector<FrameEstimate> estimate_forwards(const std::vector<ObservedFrame>& frames,
                                             FrameEstimator& estimator,
                                             const PassQuestion& stop) {
  std::vector<FrameEstimate> estimates;
  estimates.reserve(frames.size());
  for (const ObservedFrame& frame : frames) {
    if (stop(estimates.size(), frames.size())) break;
    estimates.push_back(estimator.next(frame));
  }
  return estimates;
}

// All frames again in windows that overlap: each is solved with a look ahead, and the next one
// begins with the last two frames of what stands.
void improve_in_windows(std::vector<FrameEstimate>& estimates,
                        FrameEstimator& estimator,
                        const RefineOptions& options,
                        const PassQuestion& stop) {
  constexpr std::size_t kCarried = 2;
  const auto keep = static_cast<std::size_t>(options.window_frames);
  const auto ahead = static_cast<std::size_t>(options.lookahead_frames);
  for (std::size_t begin = 0; begin < estimates.size(); begin += keep) {
    const std::size_t from = begin - std::min(begin, kCarried);
    const std::size_t end = std::min(estimates.size(), begin + keep + ahead);
    if (stop(begin, estimates.size())) return;
    estimator.improve(std::span(estimates).subspan(from, end - from),
                      static_cast<int>(begin - from));
  }
}

// The closed form is judged by the model like any other estimate, but claims no sigma.
void judge_all(std::vector<FrameEstimate>& estimates,
               FrameEstimator& estimator,
               const FaceResponse& response,
               const RetargetOptions& options) {
  for (FrameEstimate& estimate : estimates) estimator.judge(estimate);
  if (options.refine) {
    carry_sigma(estimates, options.refinement.fastest_per_s * agility_of(response), options.causal);
    return;
  }
  for (FrameEstimate& estimate : estimates) estimate.posterior.sigma.resize(0);
}

// The performer's full strength of every control, as multiples of the model's; controls that the
// clip hardly uses are left out. Where the estimate ends at its bound, what is left of the motion
// says how far beyond it would go.
std::vector<std::pair<std::string, double>> range_of_motion(
    const std::vector<FrameEstimate>& estimates, const Calibration& calibration) {
  constexpr double kUsed = 0.4;
  constexpr double kAtBound = 0.98;
  constexpr double kFull = 0.98;  // quantile: one frame is no range
  const int n = calibration.response.num_controls();
  std::vector<std::vector<double>> reach(static_cast<std::size_t>(n));
  Eigen::VectorXd moved;
  Eigen::MatrixXd slope;
  for (const FrameEstimate& estimate : estimates) {
    const Eigen::VectorXd& u = estimate.refined.controls;
    calibration.response.displace(u, moved, &slope);
    for (int i = 0; i < n; ++i) {
      double along = 0.0;
      double square = 0.0;
      for (int c = 0; c < kNumContours && u[i] > kAtBound; ++c) {
        if (!estimate.reading.displacements.usable[static_cast<std::size_t>(c)]) continue;
        for (int k = first_node(c); k <= last_node(c); ++k) {
          const Point2 m = slope.col(i).segment<2>(2 * k);
          const Point2 left = estimate.reading.displacements.mm.col(k) - moved.segment<2>(2 * k);
          along += m.dot(left);
          square += m.squaredNorm();
        }
      }
      const double beyond = square > 0.0 ? std::max(0.0, along / square) : 0.0;
      reach[static_cast<std::size_t>(i)].push_back(u[i] + beyond);
    }
  }
  std::vector<std::pair<std::string, double>> range;
  for (int i = 0; i < n; ++i) {
    std::vector<double>& values = reach[static_cast<std::size_t>(i)];
    if (values.empty()) continue;
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(kFull * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    if (*at < kUsed) continue;
    const bool is_jaw = i == n - 1;
    range.emplace_back(is_jaw ? "jaw" : calibration.response.muscles[static_cast<std::size_t>(i)],
                       std::clamp(*at * calibration.gain[i],
                                  PerformerProfile::kLeastRange,
                                  PerformerProfile::kLargestRange));
  }
  return range;
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

// One row per picture of the clip, in which those without a face stay empty.
ContractionTrack export_track(const std::vector<ContourSet>& contours,
                              const UsableFrames& usable,
                              const std::vector<FrameEstimate>& estimates,
                              const Calibration& calibration) {
  ContractionTrack track;
  track.muscles = calibration.response.muscles;
  const bool complete = estimates.size() == usable.frames.size();
  const std::size_t num_frames = complete ? contours.size() : usable.source[estimates.size()];
  for (std::size_t t = 0, next = 0; t < num_frames; ++t) {
    Contractions out;
    if (next < estimates.size() && usable.source[next] == t) {
      out = contractions_of(estimates[next++], calibration);
    }
    out.frame_index = contours[t].frame_index;
    out.time_s = contours[t].time_s;
    track.frames.push_back(std::move(out));
  }
  return track;
}

}  // namespace

void RetargetOptions::check() const {
  require(neutral_frame >= -1,
          "neutral_frame is " + std::to_string(neutral_frame) +
              "; expected a frame number, or -1 to have it found");
  require(focal_length_px == 0.0 || (focal_length_px >= 10.0 && focal_length_px <= 1e6),
          "focal_length_px is " + std::to_string(focal_length_px) +
              "; expected a value in [10, 1e6], or 0 for unknown");
  observation.check();
  refinement.check();
  lattice_loop.check();
}

ContractionTrack retarget(const std::vector<ContourSet>& contours,
                          const FaceModel& face,
                          const RetargetOptions& options,
                          RetargetReport& report,
                          const RetargetQuestion& stop) {
  options.check();
  report = {};
  report.response_not_converged = face.response.settles_not_converged;
  const UsableFrames usable = usable_frames(contours);
  const Calibration calibration = calibrate_clip(usable.frames, face, options, report);

  FrameEstimator estimator(calibration, options, face.lattice);
  const bool in_windows = options.refine && !options.causal;
  const int num_passes = in_windows ? 2 : 1;
  std::vector<FrameEstimate> estimates =
      estimate_forwards(usable.frames, estimator, {stop, 0, num_passes});
  const bool stopped = estimates.size() < usable.frames.size();
  if (in_windows && !stopped) {
    improve_in_windows(estimates, estimator, options.refinement, {stop, 1, num_passes});
  }
  judge_all(estimates, estimator, calibration.response, options);

  const ContractionTrack track = export_track(contours, usable, estimates, calibration);
  for (std::size_t t = 0; t < estimates.size(); ++t) {
    const FrameEstimate& estimate = estimates[t];
    ++report.frames_estimated;
    if (!estimate.refined.converged) ++report.frames_not_converged;
    report.insights.push_back({usable.frames[t].frame_index,
                               estimate.refined.converged,
                               estimate.refined.cost,
                               estimate.refined.optimality,
                               estimate.posterior.influence});
  }
  report.lattice = estimator.lattice_figures();
  report.jaw_carry = calibration.jaw_carry;
  report.face_unit_px = calibration.performer.face_unit_px;
  report.millimetre_per_px = calibration.performer.millimetre_per_px;
  report.median_residual_px = median_residual(track);
  report.performer.neutral = calibration.neutral;
  report.performer.range = range_of_motion(estimates, calibration);
  return track;
}

}  // namespace zygoma
