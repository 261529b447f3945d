// Options of the commands that assemble a face.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "face/scene.h"
#include "src/cli/command.h"
#include "src/pipeline/animate_face.h"

namespace zygoma {

// A face ready to move; the simulator refers to the anatomy.
struct AssembledFace {
  std::shared_ptr<const Anatomy> anatomy;
  Simulator simulator;
};

class FaceOptions {
 public:
  void declare(OptionSink& options);
  AssembledFace assemble() const;
  // The same as a scene without motion; from a scene file, if a path is given, which then has the
  // last word. Throws InputError naming an option that contradicts the file.
  Scene scene(const std::string& path) const;

 private:
  HeadOptions head_;
  double residual_ = 1e-4;
};

class AnimationOptions {
 public:
  void declare(OptionSink& options);
  AnimateOptions animate_options() const;

 private:
  int panel_height_px_ = 0;
  bool no_bars_ = false;
  int samples_per_pixel_ = RenderOptions{}.samples_per_pixel;
  VideoWriterOptions encoding_;
  int num_threads_ = 2;
};

}  // namespace zygoma
