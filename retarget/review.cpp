#include "retarget/review.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace zygoma {
namespace {

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<ContourFit> contour_fits(const ContractionTrack& track, double face_unit_px) {
  std::map<std::string, std::vector<double>> by_contour;
  for (const Contractions& frame : track.frames) {
    for (const auto& [name, residual] : frame.residual_px) by_contour[name].push_back(residual);
  }
  std::vector<ContourFit> fits;
  for (const Feature& feature : kFeatureSchema) {
    const auto found = by_contour.find(std::string(feature.name));
    if (found == by_contour.end()) continue;
    ContourFit fit;
    fit.contour = found->first;
    fit.num_frames = static_cast<int>(found->second.size());
    fit.median_px = quantile(found->second, 0.5);
    fit.p90_px = quantile(found->second, 0.9);
    if (face_unit_px > 0.0) fit.median_percent = 100.0 * fit.median_px / face_unit_px;
    fits.push_back(fit);
  }
  return fits;
}

std::vector<ControlEvidence> control_evidence(const ContractionTrack& track,
                                              const RetargetReport& report) {
  std::map<int, const Contractions*> by_frame;
  for (const Contractions& frame : track.frames) by_frame[frame.frame_index] = &frame;
  const std::size_t n = track.muscles.size();
  std::vector<ControlEvidence> all;
  for (std::size_t i = 0; i <= n; ++i) {
    ControlEvidence evidence;
    evidence.control = i < n ? track.muscles[i] : "jaw";
    evidence.strongest = -1.0;
    const FrameInsight* peak = nullptr;
    int observed = 0;
    for (const FrameInsight& insight : report.insights) {
      const auto found = by_frame.find(insight.frame_index);
      if (found == by_frame.end() || found->second->value.size() != n) continue;
      const Contractions& frame = *found->second;
      const double value = i < n ? frame.value[i] : frame.jaw;
      if (!frame.observed.empty()) observed += i < n ? frame.observed[i] : frame.jaw_observed;
      if (value > evidence.strongest) {
        evidence.strongest = value;
        peak = &insight;
      }
    }
    if (peak == nullptr) continue;
    evidence.frame_index = peak->frame_index;
    evidence.observed_share =
        static_cast<double>(observed) / static_cast<double>(report.insights.size());
    if (peak->influence.rows() > static_cast<Eigen::Index>(i)) {
      const Eigen::VectorXd variance =
          peak->influence.row(static_cast<Eigen::Index>(i)).cwiseAbs2();
      const double total = variance.sum();
      for (int c = 0; c < kNumContours && total > 0.0; ++c) {
        evidence.share[static_cast<std::size_t>(c)] = variance[c] / total;
      }
    }
    all.push_back(evidence);
  }
  return all;
}

// How much a frame stands out, and the strongest reason.
SuspectFrame judge(const Contractions& frame,
                   const Contractions* before,
                   const std::map<std::string, double>& usual_px,
                   bool converged) {
  constexpr double kMuchMore = 3.0;  // times the usual residual
  constexpr double kFast_per_s = 12.0;
  SuspectFrame suspect{frame.frame_index, frame.time_s, 0.0, {}};
  const auto consider = [&](double badness, const std::string& reason) {
    if (badness <= suspect.badness) return;
    suspect.badness = badness;
    suspect.reason = reason;
  };
  if (frame.value.empty()) {
    consider(3.0, "no face");
    return suspect;
  }
  if (!converged) consider(2.0, "did not converge");
  if (!frame.success) consider(1.5, "a contour is lost");
  consider((1.0 - frame.confidence) / 0.8, "low confidence");
  for (const auto& [name, residual] : frame.residual_px) {
    consider(residual / (kMuchMore * usual_px.at(name)), name + " does not fit the model");
  }
  if (before != nullptr && before->value.size() == frame.value.size()) {
    const double step_s = std::max(1e-3, frame.time_s - before->time_s);
    double fastest = std::abs(frame.jaw - before->jaw);
    for (std::size_t i = 0; i < frame.value.size(); ++i) {
      fastest = std::max(fastest, std::abs(frame.value[i] - before->value[i]));
    }
    consider(fastest / step_s / kFast_per_s, "a jump");
  }
  return suspect;
}

std::vector<SuspectFrame> suspect_frames(const ContractionTrack& track,
                                         const RetargetReport& report,
                                         const std::vector<ContourFit>& fits) {
  constexpr std::size_t kMost = 10;
  constexpr double kApart_s = 0.5;  // a few diverse ones, not one moment ten times
  constexpr double kLeastUsual_px = 0.5;
  std::map<std::string, double> usual_px;
  for (const ContourFit& fit : fits) {
    usual_px[fit.contour] = std::max(kLeastUsual_px, fit.median_px);
  }
  std::map<int, bool> converged;
  for (const FrameInsight& insight : report.insights) {
    converged[insight.frame_index] = insight.converged;
  }
  std::vector<SuspectFrame> all;
  for (std::size_t t = 0; t < track.frames.size(); ++t) {
    const auto found = converged.find(track.frames[t].frame_index);
    all.push_back(judge(track.frames[t],
                        t > 0 ? &track.frames[t - 1] : nullptr,
                        usual_px,
                        found == converged.end() || found->second));
  }
  std::stable_sort(all.begin(), all.end(), [](const SuspectFrame& a, const SuspectFrame& b) {
    return a.badness > b.badness;
  });
  std::vector<SuspectFrame> chosen;
  for (const SuspectFrame& next : all) {
    if (next.badness < 1.0 || chosen.size() == kMost) break;
    const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](const SuspectFrame& taken) {
      return std::abs(taken.time_s - next.time_s) > kApart_s;
    });
    if (is_apart) chosen.push_back(next);
  }
  return chosen;
}

}  // namespace

RetargetReview review(const ContractionTrack& track, const RetargetReport& report) {
  RetargetReview result;
  result.contours = contour_fits(track, report.face_unit_px);
  result.controls = control_evidence(track, report);
  result.suspects = suspect_frames(track, report, result.contours);
  return result;
}

}  // namespace zygoma
