#include "src/cli/retarget_options.h"

#include <cstdio>
#include <limits>

#include "src/base/check.h"
#include "src/io/contractions_file.h"
#include "src/io/profile_file.h"
#include "src/io/retarget_report_file.h"

namespace zygoma {
namespace {

// Relative differences of proportions: frames of one person differ by a few per cent, two people by
// ten and more; a profile this far off belongs to nobody with this face.
constexpr double kDoubtfulProfile = 0.10;
constexpr double kWrongProfile = 0.30;

FaceLevel parse_level(const std::string& name) {
  if (name == "linear") return FaceLevel::kLinear;
  return name == "lattice" ? FaceLevel::kLattice : FaceLevel::kCorrected;
}

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f %%", 100.0 * share);
  return text;
}

}  // namespace

void RetargetingOptions::declare(OptionSink& options) {
  options.integer(
      "--neutral",
      neutral_frame_,
      {-1, std::numeric_limits<int>::max()},
      "number of a frame that shows the face at rest; -1: the profile's, else found in the clip");
  options.choice("--method",
                 method_,
                 {"refined", "closed-form"},
                 "closed-form: the estimates of the paper alone, without the refinement against "
                 "the face model: quick, coarse");
  options.choice("--level",
                 level_,
                 {"auto", "linear", "corrected", "lattice"},
                 "what the refinement takes for the face: its linear response; with saturation and "
                 "pairwise correctives; or the equilibrium of the lattice itself in every frame; "
                 "auto: corrected, or as --quality of run says");
  options.flag("--live",
               live_,
               "estimate as a live performance has to: no frame knows those after it; the filter "
               "of --smooth is then causal, too");
  options.choice("--smooth",
                 smoothing_,
                 {"none", "responsive", "balanced", "stable"},
                 "write contractions_filtered.csv as well: without delay, or with --live by "
                 "One-Euro filters; contractions.csv is never filtered");
  options.number("--focal-length",
                 focal_length_px_,
                 {0.0, 1e6},
                 "of the performer's camera, pixels; 0: unknown, taken to be 0.9 m away");
  options.text("--profile", profile_path_, "FILE", "what is known of the performer from before");
  options.text(
      "--save-profile",
      save_profile_path_,
      "FILE",
      "write the face at rest and the range of motion that this clip shows, for --profile");
}

void RetargetingOptions::prepare() {
  require(focal_length_px_ == 0.0 || focal_length_px_ >= 10.0,
          "--focal-length: expected 0 for unknown, or at least 10");
  if (!profile_path_.empty()) profile_ = read_profile(profile_path_);
}

void RetargetingOptions::leave_quality_to(const std::string& who) const {
  require(level_ == "auto", "--level: set by " + who + ", expected one or the other");
}

void RetargetingOptions::set_usual(const RunQuality& quality) { usual_ = quality; }

RetargetOptions RetargetingOptions::estimation() const {
  RetargetOptions options;
  options.neutral_frame = neutral_frame_;
  options.causal = live_;
  options.focal_length_px = focal_length_px_;
  usual_.apply(options);
  if (level_ != "auto") options.level = parse_level(level_);
  options.refine = method_ == "refined";
  return options;
}

Retargeted RetargetingOptions::retarget(const std::vector<ContourSet>& contours,
                                        const FaceResponse& response,
                                        Simulator& lattice,
                                        RunContext& context) const {
  const RetargetOptions options = estimation();
  Retargeted result;
  context.progress.begin("retarget", static_cast<int>(contours.size()));
  const Stopwatch watch;
  const RetargetQuestion stop = [&](double done) {
    context.progress.update(static_cast<int>(done * static_cast<double>(contours.size())));
    return context.stop();
  };
  const FaceModel face{response, &lattice, profile()};
  result.track = zygoma::retarget(contours, face, options, result.report, stop);
  context.progress.update(static_cast<int>(result.track.frames.size()));
  context.progress.end();
  result.figures = {"retarget", static_cast<int>(result.track.frames.size()), watch.elapsed_ms()};
  if (smoothing_ != "none") {
    const SmoothIntent intent = parse_smooth_intent(smoothing_);
    result.smooth =
        live_ ? smooth_track_live(result.track, intent) : smooth_track(result.track, intent);
  }
  result.remarks = remarks_on(result.report);
  return result;
}

std::vector<std::string> RetargetingOptions::remarks_on(const RetargetReport& report) const {
  std::vector<std::string> lines;
  if (!report.neutral_doubts.empty()) {
    std::string line = report.neutral_frame < 0 ? std::string("the neutral of the profile")
                                                : "frame " + std::to_string(report.neutral_frame) +
                                                      ", taken as neutral,";
    line += " may not be a face at rest: ";
    for (std::size_t i = 0; i < report.neutral_doubts.size(); ++i) {
      line += (i > 0 ? ", " : "") + report.neutral_doubts[i];
    }
    lines.push_back(line + "; --neutral FRAME names a better one");
  }
  if (profile_) {
    require(report.profile_difference < kWrongProfile,
            profile_path_ +
                ": is of another performer, expected one whose proportions differ by "
                "less than " +
                percent(kWrongProfile) + ", not " + percent(report.profile_difference));
    if (report.profile_difference > kDoubtfulProfile) {
      lines.push_back(profile_path_ + ": may be of another performer, the proportions differ by " +
                      percent(report.profile_difference));
    }
  }
  return lines;
}

void RetargetingOptions::write(const Retargeted& result, const OutputFolder& folder) const {
  write_contractions_csv(folder / "contractions.csv", result.track);
  if (result.smooth) write_contractions_csv(folder / "contractions_filtered.csv", *result.smooth);
  write_retarget_report(
      folder / "retarget_report.json", review(result.track, result.report), result.report);
  write_contraction_plot(
      folder / "contractions.svg", result.track, result.smooth ? &*result.smooth : nullptr);
  if (!save_profile_path_.empty()) write_profile(save_profile_path_, result.report.performer);
}

}  // namespace zygoma
