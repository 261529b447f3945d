#include "src/pipeline/pick_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include "retarget/measure_response.h"
#include "retarget/observe.h"

namespace zygoma {
namespace {

constexpr std::size_t kTrialFrames = 24;
constexpr int kWarmFrames = 8;              // of a trial that are not representative
constexpr double kUsualTracking_ms = 5.0;   // per frame, as about_frame_ms
constexpr double kUsualClipFrames = 300.0;  // where nobody knows
constexpr double kRoom = 0.95;              // share of a budget that a level is tried for

// Mean distance that the contours' nodes have gone since the frame before; 0 where they are not
// seen in both.
double motion_px(const ContourSet& before, const ContourSet& now) {
  double sum = 0.0;
  int count = 0;
  for (const Contour& contour : now.contours) {
    const Contour* then = before.visible(contour.name);
    if (then == nullptr || contour.points_px.size() != then->points_px.size()) continue;
    for (std::size_t i = 0; i < contour.points_px.size(); ++i, ++count) {
      sum += (contour.points_px[i] - then->points_px[i]).norm();
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// The frames of a trial: those in a row, all with a face, that move most like the clip on average.
std::vector<ContourSet> typical_stretch(const std::vector<ContourSet>& clip) {
  const std::size_t length = std::min(kTrialFrames, clip.size());
  std::vector<double> moved{0.0};  // until frame k
  std::vector<int> unseen{0};      // before frame k
  for (std::size_t k = 0; k < clip.size(); ++k) {
    if (k > 0) moved.push_back(moved.back() + motion_px(clip[k - 1], clip[k]));
    unseen.push_back(unseen.back() + (is_usable(stack_contours(clip[k])) ? 0 : 1));
  }
  const double usual =
      moved.back() / static_cast<double>(std::max<std::size_t>(1, clip.size() - 1));
  std::size_t best = 0;
  double best_rank = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + length <= clip.size(); ++k) {
    const double mean = (moved[k + length - 1] - moved[k]) / static_cast<double>(length);
    const int dark = unseen[k + length] - unseen[k];
    const double rank = std::abs(mean - usual) + 1e6 * dark;
    if (rank >= best_rank) continue;
    best = k;
    best_rank = rank;
  }
  return {clip.begin() + static_cast<std::ptrdiff_t>(best),
          clip.begin() + static_cast<std::ptrdiff_t>(best + length)};
}

// Notes when the frames of a stage came.
class FrameClock : public StageObserver {
 public:
  void begin(const std::string&, int) override {}
  void update(int num_done) override {
    if (num_done == kWarmFrames) warm_ms_ = watch_.elapsed_ms();
  }
  void end() override {}

  // Of `num_frames` in `whole_ms`, finishing included.
  RunCost cost(int num_frames, double whole_ms) const {
    if (num_frames <= kWarmFrames) return {0.0, whole_ms / std::max(1, num_frames)};
    const double frame_ms = (whole_ms - warm_ms_) / (num_frames - kWarmFrames);
    return {std::max(0.0, warm_ms_ - kWarmFrames * frame_ms), frame_ms};
  }
  double elapsed_ms() const { return watch_.elapsed_ms(); }

 private:
  Stopwatch watch_;
  double warm_ms_ = 0.0;
};

// Getting ready, a trial and the clip itself after tracking, where levels were measured.
double about_ms(const RunQuality& quality, double num_frames) {
  return quality.about_start_ms +
         quality.about_frame_ms * (num_frames + static_cast<double>(kTrialFrames));
}

RetargetQuestion question_of(const RunTask& task) {
  return [&task](double) { return task.stop && task.stop(); };
}

// What finding the neutral takes, which does not depend on the number of frames.
double neutral_ms(const std::vector<ContourSet>& stretch,
                  const FaceModel& face,
                  const RunTask& task) {
  if (task.estimation.neutral_frame >= 0) return 0.0;
  RetargetOptions options = task.estimation;
  options.refine = false;
  RetargetReport report;
  const Stopwatch watch;
  retarget(stretch, face, options, report, question_of(task));
  return watch.elapsed_ms();
}

}  // namespace

RunFaces prepare_faces(const RunQuality& quality, const StopQuestion& stop) {
  const auto make = [](const FaceQuality& wanted, std::shared_ptr<const Anatomy>& anatomy) {
    HeadOptions head;
    TissueModel tissue;
    SettleOptions settle;
    wanted.apply(head, tissue, settle);
    head.check();
    anatomy = std::make_shared<const Anatomy>(make_generic_head({}, head));
    return std::make_unique<Simulator>(anatomy, tissue, settle);
  };
  RunFaces faces;
  faces.drawn = make(quality.face, faces.anatomy);
  std::shared_ptr<const Anatomy> of_estimation;
  if (!quality.has_one_face()) faces.other = make(quality.estimation, of_estimation);
  faces.response = measure_response(faces.estimation(), {}, stop);
  return faces;
}

RunCost try_quality(const RunQuality& quality, RunFaces& faces, const RunTask& task) {
  const std::vector<ContourSet> stretch = typical_stretch(task.tracked.contours);
  const auto num_frames = static_cast<int>(stretch.size());
  const FaceModel face{faces.response, &faces.estimation(), task.profile};
  RetargetOptions options = task.estimation;
  quality.apply(options);
  RunCost cost;
  cost.begin_ms = neutral_ms(stretch, face, task);
  const auto seen = std::find_if(stretch.begin(), stretch.end(), [](const ContourSet& set) {
    return is_usable(stack_contours(set));
  });
  if (seen == stretch.end()) return cost;
  options.neutral_frame = seen->frame_index;
  RetargetReport report;
  const Stopwatch watch;
  const ContractionTrack track = retarget(stretch, face, options, report, question_of(task));
  cost.frame_ms = watch.elapsed_ms() / num_frames;
  if (track.frames.empty() || (task.stop && task.stop())) return cost;

  FrameClock clock;
  animate_face(track,
               *faces.drawn,
               faces.anatomy,
               Performance{task.tracked.source, stretch},
               task.scratch,
               task.drawing(quality),
               clock,
               task.stop);
  const RunCost drawing = clock.cost(num_frames, clock.elapsed_ms());
  std::filesystem::remove(task.scratch);
  cost.begin_ms += drawing.begin_ms;
  cost.frame_ms += drawing.frame_ms;
  return cost;
}

double slowness(const TrackedVideo& tracked) {
  return std::max(0.1, tracked.figures.frame_ms() / kUsualTracking_ms);
}

std::size_t guess_quality(double budget_ms,
                          std::size_t num_frames,
                          double slower,
                          std::optional<double> passed_ms) {
  const double frames = num_frames > 0 ? static_cast<double>(num_frames) : kUsualClipFrames;
  const double passed = passed_ms.value_or(kUsualTracking_ms * frames);
  std::size_t guess = 0;
  for (std::size_t k = 0; k < run_qualities().size(); ++k) {
    if (passed + slower * about_ms(run_qualities()[k], frames) <= kRoom * budget_ms * frames) {
      guess = k;
    }
  }
  return guess;
}

RunPick pick_by_trials(double budget_ms,
                       std::size_t guess,
                       std::size_t num_frames,
                       const std::function<RunCost(std::size_t)>& cost_of,
                       const std::function<double()>& passed_ms) {
  const std::vector<RunQuality>& all = run_qualities();
  const double whole_ms = budget_ms * static_cast<double>(num_frames);
  std::map<std::size_t, RunCost> tried;
  std::optional<std::size_t> best;
  std::size_t too_slow = all.size();  // the quickest that is known to be
  for (std::size_t at = guess;;) {
    const RunCost cost = tried[at] = cost_of(at);
    if (passed_ms() + cost.total_ms(num_frames) <= whole_ms) {
      best = at;
    } else {
      too_slow = at;
    }
    // A trial takes time itself: the next one is the most accurate that would probably fit, if this
    // machine is as much slower or quicker there as it was here.
    const double scale = cost.frame_ms / all[at].about_frame_ms;
    std::optional<std::size_t> next;
    for (std::size_t k = best ? *best + 1 : 0; k < too_slow; ++k) {
      const double ms = scale * about_ms(all[k], static_cast<double>(num_frames));
      if (passed_ms() + ms <= kRoom * whole_ms) next = k;
    }
    if (!next && !best && too_slow > 0) next = 0;
    if (!next) break;
    at = *next;
  }
  RunPick pick;
  pick.quality = best.value_or(0);
  pick.expected_ms = (passed_ms() + tried[pick.quality].total_ms(num_frames)) /
                     static_cast<double>(std::max<std::size_t>(1, num_frames));
  return pick;
}

RunPick pick_for_run(double budget_ms,
                     RunFaces draft,
                     const RunTask& task,
                     const std::function<double()>& passed_ms) {
  const std::size_t num_frames = task.tracked.contours.size();
  const std::size_t guess =
      guess_quality(budget_ms, num_frames, slowness(task.tracked), passed_ms());
  std::map<std::size_t, RunFaces> faces;
  faces[0] = std::move(draft);
  const auto cost_of = [&](std::size_t k) {
    const RunQuality& quality = run_qualities()[k];
    if (task.stop && task.stop()) return RunCost();
    if (!faces.contains(k)) faces[k] = prepare_faces(quality, task.stop);
    return try_quality(quality, faces[k], task);
  };
  RunPick pick = pick_by_trials(budget_ms, guess, num_frames, cost_of, passed_ms);
  if (!faces.contains(pick.quality)) pick.quality = 0;  // stopped
  pick.faces = std::move(faces[pick.quality]);
  return pick;
}

std::size_t pick_for_run_tolerance(double tolerance_mm) {
  const std::vector<RunQuality>& all = run_qualities();
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k].face.expected_rms_mm <= tolerance_mm) return k;
  }
  return all.size() - 1;
}

}  // namespace zygoma
