#include "src/cli/face_options.h"

#include <cstdio>

#include "face/muscle_table.h"
#include "src/base/check.h"
#include "src/io/scene_file.h"
#include "src/pipeline/pick_quality.h"
#include "src/pipeline/tradeoff_tissue.h"

namespace zygoma {
namespace {

std::string remark_on(const QualityPick& pick, double budget_ms) {
  const FaceQuality& quality = pick.quality;
  char text[240];
  std::snprintf(
      text,
      sizeof text,
      "quality %s: %s layers, %d surface vertices; expected %.2f mm RMS from the reference",
      quality.name.c_str(),
      quality.bi_layer ? "two" : "three",
      quality.surface_vertices,
      quality.expected_rms_mm);
  std::string remark = text;
  if (budget_ms > 0.0) {
    std::snprintf(text, sizeof text, " and %.2f ms per frame", pick.expected_ms);
    remark += text;
    const std::string forecast = budget_forecast(pick.expected_ms, budget_ms);
    if (!forecast.empty()) remark += "; " + forecast;
  }
  return remark;
}

}  // namespace

void FaceOptions::declare(OptionSink& options, BudgetOf what) {
  options.choice("--quality",
                 quality_,
                 {"draft", "standard", "fine", "reference"},
                 "a point on the front of what accuracy costs in time (see `zygoma tradeoff`)");
  options.number(
      "--budget",
      budget_ms_,
      {0.0, 10000.0},
      what == BudgetOf::kSettling
          ? "processor time for a frame to settle in, ms: picks the most accurate quality that "
            "fits on this machine"
          : "time for the whole run, ms for every frame of the clip, from start to end on the "
            "wall: "
            "picks the most accurate quality that fits on this machine");
  options.number("--tolerance",
                 tolerance_mm_,
                 {0.0, 10.0},
                 "picks the quickest quality whose skin is that close to the reference, mm RMS");
  options.integer("--surface-vertices",
                  surface_vertices_,
                  {0, 4000},
                  "about how many nodes a layer of the lattice face has, 300 to 4000: more make "
                  "finer folds and take longer; 0: by --quality");
  options.number("--residual",
                 residual_,
                 {0.0, 0.1},
                 "share of the load that may be left unbalanced in a settled face: less is slower "
                 "and closer to the true equilibrium; 0: by --quality");
}

void FaceOptions::check() const {
  const bool by_quality = quality_ != kUsualQuality;
  const int asked = by_quality + (budget_ms_ > 0.0) + (tolerance_mm_ > 0.0);
  require(asked <= 1, "--quality, --budget, --tolerance: expected one of them at most");
  if (budget_ms_ == 0.0 && tolerance_mm_ == 0.0) return;
  require(surface_vertices_ == 0,
          "--surface-vertices: set by --budget or --tolerance, expected one or the other");
  require(residual_ == 0.0,
          "--residual: set by --budget or --tolerance, expected one or the other");
}

void FaceOptions::refine(FaceQuality& quality) const {
  if (surface_vertices_ > 0) quality.surface_vertices = surface_vertices_;
  if (residual_ > 0.0) quality.relative_residual = residual_;
}

ChosenScene FaceOptions::scene(const std::string& path, const ContractionTrack* track) const {
  check();
  if (!path.empty()) {
    require(surface_vertices_ == 0, "--surface-vertices: the scene says (head.surface_vertices)");
    require(residual_ == 0.0, "--residual: the scene says (solver.relative_residual)");
    require(quality_ == kUsualQuality && budget_ms_ == 0.0 && tolerance_mm_ == 0.0,
            "--quality, --budget, --tolerance: the scene says (head, tissue, solver)");
    return {read_scene(path), {}};
  }
  Scene scene;
  QualityPick pick{face_quality(quality_), 0.0};
  if (tolerance_mm_ > 0.0) pick = pick_for_tolerance(tolerance_mm_);
  if (budget_ms_ > 0.0) {
    const ContractionTrack usual_track =
        sample_motion(tradeoff_motion(), muscles_used(tradeoff_motion(), standard_muscle_names()));
    pick = pick_for_budget(
        budget_ms_, track == nullptr ? usual_track : *track, scene.identity, scene.tissue);
  }
  refine(pick.quality);
  pick.quality.apply(scene.head, scene.tissue, scene.settle);
  scene.head.check();
  const bool usual = pick.quality.name == kUsualQuality && budget_ms_ == 0.0;
  return {scene, usual ? "" : remark_on(pick, budget_ms_)};
}

AssembledFace FaceOptions::assemble(const ContractionTrack* track) const {
  const ChosenScene chosen = scene({}, track);
  auto anatomy = std::make_shared<const Anatomy>(make_generic_head({}, chosen.scene.head));
  return {anatomy, Simulator(anatomy, chosen.scene.tissue, chosen.scene.settle), chosen.remark};
}

std::string FaceOptions::verdict(double frame_ms) const {
  if (budget_ms_ == 0.0) return {};
  char text[80];
  std::snprintf(text, sizeof text, "a frame settled in %.2f ms on average, ", frame_ms);
  return text + budget_verdict(frame_ms, budget_ms_);
}

void AnimationOptions::declare(OptionSink& options) {
  options.integer("--height",
                  panel_height_px_,
                  {0, 2160},
                  "of the picture, pixels; 0: that of the video, at most 720");
  options.choice(
      "--view", view_, view_names(), "of the whole head; left out: the face from the front");
  options.choice(
      "--overlay",
      overlay_,
      overlay_names(),
      "what to lay over the face: the surface of the lattice, the muscles that pull, how "
      "the tissue below changes its volume, how the skin is stretched");
  options.flag("--no-bars", no_bars_, "leave out the panel with one bar per muscle");
  options.integer("--samples",
                  samples_per_pixel_,
                  {0, 16},
                  "rays for a pixel that an edge runs through; 1: edges stay jagged; 0: 2, or 1 "
                  "for --quality draft of run");
  options.choice("--encoding",
                 encoding_.preset,
                 {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"},
                 "effort of the H.264 encoder, slower makes smaller files");
  options.integer("--threads", num_threads_, {1, 64}, "that render and encode");
}

AnimateOptions AnimationOptions::animate_options(int usual_samples) const {
  AnimateOptions options;
  options.panel_height_px = panel_height_px_;
  options.bars = !no_bars_;
  if (!view_.empty()) options.view = parse_view(view_);
  options.overlay = parse_overlay(overlay_);
  options.render.samples_per_pixel = samples_per_pixel_ > 0 ? samples_per_pixel_ : usual_samples;
  options.render.num_threads = num_threads_;
  options.encoding = encoding_;
  options.encoding.num_threads = num_threads_;
  return options;
}

}  // namespace zygoma
