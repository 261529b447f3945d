#include "src/cli/face_options.h"

#include "src/base/check.h"
#include "src/io/scene_file.h"

namespace zygoma {

void FaceOptions::declare(OptionSink& options) {
  options.integer(
      "--surface-vertices",
      head_.num_surface_vertices,
      {300, 4000},
      "about how many nodes a layer of the lattice face has: more make finer folds and take "
      "longer");
  options.number("--residual",
                 residual_,
                 {1e-8, 0.1},
                 "share of the load that may be left unbalanced in a settled face: less is slower "
                 "and closer to the true equilibrium");
}

AssembledFace FaceOptions::assemble() const {
  auto anatomy = std::make_shared<const Anatomy>(make_generic_head({}, head_));
  SettleOptions settle;
  settle.relative_residual = residual_;
  return {anatomy, Simulator(anatomy, {}, settle)};
}

Scene FaceOptions::scene(const std::string& path) const {
  const FaceOptions usual;
  if (!path.empty()) {
    require(head_.num_surface_vertices == usual.head_.num_surface_vertices,
            "--surface-vertices: the scene says (head.surface_vertices)");
    require(residual_ == usual.residual_, "--residual: the scene says (solver.relative_residual)");
    return read_scene(path);
  }
  Scene scene;
  scene.head = head_;
  scene.settle.relative_residual = residual_;
  return scene;
}

void AnimationOptions::declare(OptionSink& options) {
  options.integer("--height",
                  panel_height_px_,
                  {0, 2160},
                  "of the picture, pixels; 0: that of the video, at most 720");
  options.flag("--no-bars", no_bars_, "leave out the panel with one bar per muscle");
  options.integer("--samples",
                  samples_per_pixel_,
                  {1, 16},
                  "rays for a pixel that an edge runs through; 1: edges stay jagged");
  options.choice("--encoding",
                 encoding_.preset,
                 {"ultrafast", "superfast", "veryfast", "faster", "fast", "medium", "slow"},
                 "effort of the H.264 encoder, slower makes smaller files");
  options.integer("--threads", num_threads_, {1, 64}, "that render and encode");
}

AnimateOptions AnimationOptions::animate_options() const {
  AnimateOptions options;
  options.panel_height_px = panel_height_px_;
  options.bars = !no_bars_;
  options.render.samples_per_pixel = samples_per_pixel_;
  options.render.num_threads = num_threads_;
  options.encoding = encoding_;
  options.encoding.num_threads = num_threads_;
  return options;
}

}  // namespace zygoma
