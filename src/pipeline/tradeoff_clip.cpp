#include "src/pipeline/tradeoff_clip.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "retarget/measure_response.h"
#include "src/pipeline/comparison.h"

namespace zygoma {
namespace {

// Processor time of the tracker alone: decoding has a thread of its own.
TrackedVideo track_with(const TradeoffClip& clip,
                        const TrackerChoice& choice,
                        StageObserver& observer,
                        const StopQuestion& stop,
                        double& frame_ms) {
  TrackLimits limits;
  limits.duration_s = clip.duration_s;
  limits.second_looks = choice.second_looks;
  const double begin_ms = thread_ms();
  TrackedVideo tracked = track_video(clip.video, {}, choice.options, observer, stop, limits);
  frame_ms = (thread_ms() - begin_ms) / std::max(1.0, static_cast<double>(tracked.contours.size()));
  return tracked;
}

// Passes on what a stage says under a name of ours.
class Renamed : public StageObserver {
 public:
  Renamed(StageObserver& observer, std::string name)
      : observer_(observer), name_(std::move(name)) {}
  void begin(const std::string&, int about_num_frames) override {
    observer_.begin(name_, about_num_frames);
  }
  void update(int num_done) override { observer_.update(num_done); }
  void end() override { observer_.end(); }

 private:
  StageObserver& observer_;
  std::string name_;
};

void compare(const std::vector<ContourSet>& contours,
             std::vector<ContourSet> truth,
             TradeoffRow& row) {
  const int last = contours.empty() ? -1 : contours.back().frame_index;
  std::erase_if(truth, [&](const ContourSet& set) { return set.frame_index > last; });
  std::vector<ContourError> errors = compare_contours(contours, truth);
  std::erase_if(errors, [](const ContourError& error) {
    return std::none_of(kContours1992.begin(), kContours1992.end(), [&](const Feature& feature) {
      return feature.name == error.contour;
    });
  });
  double cover = 0.0;
  const auto n = static_cast<double>(std::max<std::size_t>(1, errors.size()));
  for (const ContourError& error : errors) {
    row.error += error.motion_median_px / n;
    row.other_error += error.median_px / n;
    cover += error.cover / n;
  }
  row.failed = 1.0 - cover;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string times(int count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

// What differs from the usual snakes, in words.
std::string words_of(const TrackerEffort& effort) {
  const TrackerEffort usual;
  std::string words = effort.models ? "models" : "no models";
  if (effort.gaussian_levels != usual.gaussian_levels) {
    words += " " + times(effort.gaussian_levels, "Gaussian level");
  }
  if (effort.nodes != usual.nodes) words += " nodes x" + number(effort.nodes);
  if (effort.tolerance_px != usual.tolerance_px) {
    words += " to " + number(effort.tolerance_px) + " px";
  }
  if (effort.max_iterations != usual.max_iterations) {
    words += " " + times(effort.max_iterations, "iteration");
  }
  return words;
}

// Of a tracker's or an estimate's choice, before it is measured.
template <class Choice>
TradeoffRow row_of(const Choice& choice) {
  TradeoffRow row;
  row.quality = choice.name;
  row.family = choice.family;
  row.choice = choice.words;
  return row;
}

}  // namespace

std::vector<TrackerChoice> tracker_choices() {
  std::vector<TrackerChoice> all;
  const auto add = [&](const char* family,
                       PredictBy predict_by,
                       TrackerEffort effort,
                       SecondLooks looks = SecondLooks::kNone,
                       const char* name = "") -> TrackerChoice& {
    effort.predict_by = predict_by;
    TrackerChoice choice{name, family, words_of(effort), {}, looks};
    choice.options.effort = effort;
    if (looks == SecondLooks::kStart) choice.words += " second look at the start";
    if (looks == SecondLooks::kAll) choice.words += " second look at all";
    all.push_back(choice);
    return all.back();
  };
  TrackerEffort plain;
  TrackerEffort alone;
  alone.models = false;
  const auto with_nodes = [](TrackerEffort effort, double nodes) {
    effort.nodes = nodes;
    return effort;
  };
  const auto with_levels = [](TrackerEffort effort, int levels) {
    effort.gaussian_levels = levels;
    return effort;
  };
  const auto with_iterations = [](TrackerEffort effort, int iterations) {
    effort.max_iterations = iterations;
    return effort;
  };
  const auto to = [](TrackerEffort effort, double tolerance_px) {
    effort.tolerance_px = tolerance_px;
    effort.max_iterations = 2000;
    return effort;
  };
  add("not predicted", PredictBy::kNothing, alone);
  add("not predicted", PredictBy::kNothing, with_iterations(alone, 5));
  add("not predicted", PredictBy::kNothing, with_nodes(alone, 2.0));
  add("not predicted", PredictBy::kNothing, with_levels(alone, 2));
  add("not predicted", PredictBy::kNothing, with_levels(alone, 3));
  add("not predicted", PredictBy::kNothing, plain);
  add("flow from the last frame", PredictBy::kLastFrame, alone);
  add("flow from the last frame", PredictBy::kLastFrame, plain);
  add("flow and looks", PredictBy::kLooks, alone);
  add("flow and looks", PredictBy::kLooks, plain, SecondLooks::kNone, "draft");
  add("flow and looks", PredictBy::kLooks, with_nodes(plain, 0.5));
  add("flow and looks", PredictBy::kLooks, with_nodes(plain, 4.0));
  add("flow and looks", PredictBy::kLooks, with_iterations(plain, 3));
  add("flow and looks", PredictBy::kLooks, with_levels(plain, 2));
  add("flow and looks", PredictBy::kLooks, to(plain, 0.1));
  add("flow and looks", PredictBy::kLooks, to(plain, 1e-4));
  add("flow and looks", PredictBy::kLooks, plain, SecondLooks::kStart, "standard");
  add("flow and looks", PredictBy::kLooks, alone, SecondLooks::kAll);
  add("flow and looks", PredictBy::kLooks, plain, SecondLooks::kAll, "reference");
  add("explicit steps", PredictBy::kLooks, plain).options.stepping = SnakeStepping::kExplicit;
  return all;
}

TrackerChoice tracker_reference() {
  TrackerChoice choice{"", "flow and looks", "", {}, SecondLooks::kAll};
  choice.options.effort.nodes = 2.0;
  choice.options.effort.tolerance_px = 1e-4;
  choice.options.effort.max_iterations = 2000;
  choice.words = words_of(choice.options.effort) + " second look at all";
  return choice;
}

std::vector<RetargetChoice> retarget_choices() {
  std::vector<RetargetChoice> all;
  const std::array<std::pair<FaceLevel, const char*>, 3> levels{
      {{FaceLevel::kLinear, "linear"},
       {FaceLevel::kCorrected, "corrected"},
       {FaceLevel::kLattice, "lattice"}}};
  const auto add =
      [&](const char* family, const std::string& words, const RetargetOptions& options) {
        all.push_back({"", family, words, options});
        return &all.back();
      };
  RetargetOptions closed;
  closed.refine = false;
  add("closed form", "each frame by itself", closed);
  for (const auto& [level, family] : levels) {
    RetargetOptions options;
    options.level = level;
    options.causal = true;
    add(family, "live", options);
    options.causal = false;
    const RefineOptions usual;
    for (const double times : {0.25, 1.0, 2.0}) {
      const auto share = [&](int frames) { return static_cast<int>(times * frames); };
      const int window = share(usual.window_frames);
      options.refinement.window_frames = window;
      options.refinement.lookahead_frames = share(usual.lookahead_frames);
      RetargetChoice* added = add(family, "windows of " + std::to_string(window), options);
      if (times != 1.0) continue;
      if (level == FaceLevel::kLinear) added->name = "draft";
      if (level == FaceLevel::kCorrected) added->name = "standard";
      if (level == FaceLevel::kLattice) added->name = "reference";
    }
    if (level == FaceLevel::kLattice) continue;
    options.refinement = {};
    for (const double tolerance : {1e-2, 1e-6}) {
      options.refinement.tolerance = tolerance;
      options.refinement.max_iterations = tolerance < 1e-4 ? 200 : 40;
      add(family, "the usual windows to " + number(tolerance), options);
    }
  }
  return all;
}

RetargetChoice retarget_reference() {
  RetargetChoice choice{"", "lattice", "windows of 60 to 1e-06", {}};
  choice.options.level = FaceLevel::kLattice;
  choice.options.refinement.window_frames = 60;
  choice.options.refinement.lookahead_frames = 20;
  choice.options.refinement.tolerance = 1e-6;
  choice.options.refinement.max_iterations = 200;
  choice.options.lattice_loop.tolerance = 1e-3;
  choice.options.lattice_loop.max_rounds = 10;
  choice.options.lattice_loop.refresh_distance = 0.1;
  return choice;
}

TradeoffStage measure_tracker(const TradeoffClip& clip,
                              const std::vector<TrackerChoice>& choices,
                              const TrackerChoice& reference,
                              StageObserver& observer,
                              const StopQuestion& stop) {
  const bool known = !clip.true_contours.empty();
  TradeoffStage stage{"tracker",
                      "px",
                      "motion missed, median",
                      "distance px",
                      known ? "the true contours" : reference.words};
  std::vector<ContourSet> truth = clip.true_contours;
  // The reference first: without a truth it is one.
  std::vector<TrackerChoice> all{reference};
  all.insert(all.end(), choices.begin(), choices.end());
  for (const TrackerChoice& choice : all) {
    const bool is_reference = &choice == &all.front();
    TradeoffRow row = row_of(choice);
    Renamed named(observer, "tracker: " + choice.family + ", " + choice.words);
    const TrackedVideo tracked = track_with(clip, choice, named, stop, row.frame_ms);
    stage.stopped = tracked.stopped;
    if (stage.stopped) break;
    row.is_reference = is_reference && !known;
    if (row.is_reference) truth = tracked.contours;
    compare(tracked.contours, truth, row);
    stage.rows.push_back(row);
  }
  find_front(stage);
  return stage;
}

TradeoffStage measure_retarget(const TradeoffClip& clip,
                               const Scene& scene,
                               const std::vector<RetargetChoice>& choices,
                               const RetargetChoice& reference,
                               StageObserver& observer,
                               const StopQuestion& stop) {
  const bool known = !clip.true_contractions.frames.empty();
  TradeoffStage stage{"retarget",
                      "0 to 1",
                      "error of contractions, RMS",
                      "reprojection px",
                      known ? "the true contractions" : reference.words};
  ContractionTrack truth = clip.true_contractions;
  double unused_ms = 0.0;
  Renamed tracking(observer, "retarget: contours");
  const TrackedVideo tracked = track_with(clip, TrackerChoice(), tracking, stop, unused_ms);
  stage.stopped = tracked.stopped;
  if (stage.stopped) return stage;
  Simulator face(std::make_shared<const Anatomy>(make_generic_head(scene.identity, scene.head)),
                 scene.tissue,
                 scene.settle);
  const FaceResponse response = measure_response(face, {}, stop);
  if (stop && stop()) {
    stage.stopped = true;
    return stage;
  }
  const auto num_frames = static_cast<int>(tracked.contours.size());
  std::vector<RetargetChoice> all{reference};
  all.insert(all.end(), choices.begin(), choices.end());
  for (const RetargetChoice& choice : all) {
    const bool is_reference = &choice == &all.front();
    TradeoffRow row = row_of(choice);
    observer.begin("retarget: " + choice.family + ", " + choice.words, num_frames);
    const RetargetQuestion ask = [&](double done) {
      observer.update(static_cast<int>(done * num_frames));
      stage.stopped = stage.stopped || (stop && stop());
      return stage.stopped;
    };
    RetargetReport report;
    const double begin_ms = thread_ms();
    const ContractionTrack track =
        retarget(tracked.contours, {response, &face}, choice.options, report, ask);
    row.frame_ms = (thread_ms() - begin_ms) / num_frames;
    observer.end();
    if (stage.stopped) break;
    row.is_reference = is_reference && !known;
    if (row.is_reference) truth = track;
    row.error = overall_rms(compare_contractions(track, truth));
    row.other_error = report.median_residual_px;
    row.failed = static_cast<double>(report.frames_not_converged) / num_frames;
    stage.rows.push_back(row);
  }
  find_front(stage);
  return stage;
}

}  // namespace zygoma
