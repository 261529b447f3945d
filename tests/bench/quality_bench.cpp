// Levels of quality of a whole run: what each takes and how close it comes; and whether budgets are
// met.
//
//   quality_bench levels CLIP [REPEATS] [RESULT.csv] [PLOT.svg]
//   quality_bench budgets CLIP [TRIES] [RESULT.csv]
//
// Levels run in this process, stage after stage as `zygoma run` does them, alternating; medians are
// reported, on the wall and of the processors (all threads; what is plotted). The truth lies beside
// the clip: CLIP without .mp4, and .contractions.csv, .contours.csv. Budgets are given to the
// program itself, one after the other, from just above what the quickest level takes up to what the
// reference takes, and what it says is read.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "src/io/contours_file.h"
#include "src/io/contractions_file.h"
#include "src/pipeline/comparison.h"
#include "src/pipeline/machine_load.h"
#include "src/pipeline/pick_run.h"
#include "src/pipeline/tradeoff.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/silent_observer.h"

namespace zygoma {
namespace {

using bench::format;
using bench::median;

struct LevelRuns {
  std::vector<double> wall_ms, cpu_ms, start_ms, rest_ms, others;  // per frame but the start
  double contraction_rms = 0.0;
  double motion_px = 0.0;
};

struct Truth {
  ContractionTrack contractions;
  std::vector<ContourSet> contours;
};

double mean_motion_px(const std::vector<ContourError>& errors) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kContours1992.size(); ++k) sum += errors[k].motion_median_px;
  return sum / static_cast<double>(kContours1992.size());
}

void run_once(const RunQuality& quality,
              const std::string& clip,
              const Truth& truth,
              LevelRuns& runs) {
  const std::string output =
      (std::filesystem::temp_directory_path() / "zygoma_quality_bench.mp4").string();
  SilentObserver silent;
  const LoadMeter load;
  const double cpu_begin_ms = bench::cpu_ms();
  const Stopwatch whole;
  double start_ms = 0.0;
  std::future<RunFaces> prepared = std::async(std::launch::async, [&] {
    const Stopwatch watch;
    RunFaces faces = prepare_faces(quality);
    start_ms = watch.elapsed_ms();
    return faces;
  });
  TrackLimits limits;
  limits.second_looks = quality.second_looks;
  const TrackedVideo tracked = track_video(clip, {}, {}, silent, {}, limits);
  RunFaces faces = prepared.get();
  const Stopwatch rest;
  RetargetOptions options;
  quality.apply(options);
  AnimateOptions drawing;
  drawing.render.samples_per_pixel = quality.samples_per_pixel;
  RetargetReport report;
  const ContractionTrack track =
      retarget(tracked.contours, {faces.response, &faces.estimation()}, options, report);
  animate_face(track,
               *faces.drawn,
               faces.anatomy,
               Performance{clip, tracked.contours},
               output,
               drawing,
               silent,
               {});
  const auto frames = static_cast<double>(tracked.contours.size());
  runs.rest_ms.push_back(rest.elapsed_ms() / frames);
  runs.start_ms.push_back(start_ms);
  runs.wall_ms.push_back(whole.elapsed_ms() / frames);
  runs.cpu_ms.push_back((bench::cpu_ms() - cpu_begin_ms) / frames);
  runs.others.push_back(load.share_of_others());
  runs.contraction_rms = overall_rms(compare_contractions(track, truth.contractions));
  runs.motion_px = mean_motion_px(compare_contours(tracked.contours, truth.contours));
  std::filesystem::remove(output);
}

int measure_levels(const std::string& clip, int repeats, const std::string& csv, const char* plot) {
  const std::string stem = clip.substr(0, clip.rfind('.'));
  const Truth truth{read_contractions_csv(stem + ".contractions.csv"),
                    read_contours_csv(stem + ".contours.csv")};
  const std::vector<RunQuality>& all = run_qualities();
  std::vector<LevelRuns> runs(all.size());
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t k = 0; k < all.size(); ++k) run_once(all[k], clip, truth, runs[k]);
  }
  bench::Table table(csv,
                     format("quality_bench levels, %d repeats, medians", repeats),
                     "quality,ms_per_frame,cpu_ms_per_frame,start_ms,rest_ms_per_frame,"
                     "contraction_rms,contour_motion_px,skin_rms_mm,share_of_other_programs");
  TradeoffStage stage{"whole run", "0 to 1", "error of contractions, RMS", "skin mm", "the truth"};
  for (std::size_t k = 0; k < all.size(); ++k) {
    table.line(format("%s,%.2f,%.2f,%.0f,%.2f,%.4f,%.4f,%.2f,%.2f",
                      all[k].name.c_str(),
                      median(runs[k].wall_ms),
                      median(runs[k].cpu_ms),
                      median(runs[k].start_ms),
                      median(runs[k].rest_ms),
                      runs[k].contraction_rms,
                      runs[k].motion_px,
                      all[k].face.expected_rms_mm,
                      median(runs[k].others)));
    TradeoffRow row;
    row.quality = all[k].name;
    row.family = "levels";
    row.frame_ms = median(runs[k].cpu_ms);
    row.error = runs[k].contraction_rms;
    stage.rows.push_back(row);
  }
  find_front(stage);
  if (plot != nullptr) write_tradeoff_plot(plot, {stage});
  return 0;
}

// What a run with a budget says.
struct Said {
  std::string quality;
  double expected_ms = 0.0;
  double took_ms = 0.0;
  double others = 0.0;
  bool cannot = false;
};

Said run_with_budget(const std::string& clip, double budget_ms) {
  const std::string folder =
      (std::filesystem::temp_directory_path() / "zygoma_quality_bench").string();
  const std::string command = std::string(ZYGOMA_PROGRAM) + " run '" + clip + "' --budget " +
                              format("%g", budget_ms) + " -o '" + folder + "' 2>&1";
  Said said;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return said;
  char line[1000];
  while (std::fgets(line, sizeof line, pipe) != nullptr) {
    const std::string text = line;
    if (text.starts_with("quality ")) said.quality = text.substr(8, text.find(':') - 8);
    said.cannot = said.cannot || text.find("cannot be met") != std::string::npos;
    std::sscanf(line,
                "the whole run took %lf ms per frame, expected were %lf",
                &said.took_ms,
                &said.expected_ms);
    const auto at = text.find("other programs took ");
    if (at != std::string::npos) said.others = std::atof(line + at + 20) / 100.0;
  }
  pclose(pipe);
  std::filesystem::remove_all(folder);
  return said;
}

int try_budgets(const std::string& clip, int tries, const std::string& csv) {
  constexpr double kWithin = 1.2;
  constexpr double kWidest = 8.0;  // times what the quickest level takes
  const Said least = run_with_budget(clip, 1.0);
  bench::Table table(csv,
                     format("quality_bench budgets; 1 ms cannot be met: said %d, took %.1f",
                            least.cannot ? 1 : 0,
                            least.took_ms),
                     "budget_ms,quality,expected_ms,took_ms,took_over_budget,took_over_expected,"
                     "share_of_other_programs,met");
  int met = 0;
  for (int k = 0; k < tries; ++k) {
    const double share = tries > 1 ? static_cast<double>(k) / (tries - 1) : 0.0;
    const double budget_ms = std::round(1.25 * least.took_ms * std::pow(kWidest, share));
    const Said said = run_with_budget(clip, budget_ms);
    const bool is_met = said.took_ms > 0.0 && said.took_ms <= kWithin * budget_ms;
    met += is_met ? 1 : 0;
    table.line(format("%g,%s,%.2f,%.2f,%.3f,%.3f,%.2f,%d",
                      budget_ms,
                      said.quality.c_str(),
                      said.expected_ms,
                      said.took_ms,
                      said.took_ms / budget_ms,
                      said.took_ms / said.expected_ms,
                      said.others,
                      is_met ? 1 : 0));
  }
  std::printf("met within 20 %%: %d of %d\n", met, tries);
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (argc < 3 || (what != "levels" && what != "budgets")) {
    std::fprintf(stderr,
                 "usage: quality_bench levels|budgets CLIP [COUNT] [RESULT.csv] [PLOT.svg]\n");
    return 2;
  }
  try {
    const int count = argc > 3 ? std::max(1, std::atoi(argv[3])) : 0;
    const std::string csv = argc > 4 ? argv[4] : "";
    if (what == "budgets") return zygoma::try_budgets(argv[2], count > 0 ? count : 10, csv);
    return zygoma::measure_levels(
        argv[2], count > 0 ? count : 3, csv, argc > 5 ? argv[5] : nullptr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "quality_bench: %s\n", error.what());
    return 2;
  }
}
