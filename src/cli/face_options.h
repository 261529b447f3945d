// Options of the commands that assemble a face.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "face/quality.h"
#include "face/scene.h"
#include "src/cli/command.h"
#include "src/pipeline/animate_face.h"

namespace zygoma {

// A face ready to move; the simulator refers to the anatomy.
struct AssembledFace {
  std::shared_ptr<const Anatomy> anatomy;
  Simulator simulator;
  std::string remark;  // which level of quality was picked; empty for the usual one
};

struct ChosenScene {
  Scene scene;         // without motion, unless it is from a file
  std::string remark;  // as above
};

class FaceOptions {
 public:
  // What --budget is a budget of: settling alone, or a whole run, for which the command picks.
  enum class BudgetOf { kSettling, kWholeRun };
  void declare(OptionSink& options, BudgetOf what = BudgetOf::kSettling);

  // As given; 0: not.
  const std::string& quality() const { return quality_; }
  double budget_ms() const { return budget_ms_; }
  double tolerance_mm() const { return tolerance_mm_; }
  // Nodes and residual, where they are given.
  void refine(FaceQuality& quality) const;

  // `track` is what the face will do: a budget is tried on it, else on a motion of its own.
  AssembledFace assemble(const ContractionTrack* track = nullptr) const;
  // From a scene file, if a path is given, which then has the last word. Throws InputError naming
  // options that contradict the file or each other.
  ChosenScene scene(const std::string& path, const ContractionTrack* track = nullptr) const;
  // How a budget turned out; empty if there is none.
  std::string verdict(double frame_ms) const;
  // Throws InputError naming options that contradict each other.
  void check() const;

 private:
  static constexpr const char* kUsualQuality = "standard";

  std::string quality_ = kUsualQuality;
  int surface_vertices_ = 0;  // 0: by quality, as below
  double residual_ = 0.0;
  double budget_ms_ = 0.0;
  double tolerance_mm_ = 0.0;
};

class AnimationOptions {
 public:
  void declare(OptionSink& options);
  // `usual_samples`: rays for a pixel at an edge where no option says.
  AnimateOptions animate_options(int usual_samples = RenderOptions{}.samples_per_pixel) const;

 private:
  int panel_height_px_ = 0;
  bool no_bars_ = false;
  std::string view_;
  std::string overlay_ = "none";
  int samples_per_pixel_ = 0;
  VideoWriterOptions encoding_;
  int num_threads_ = 2;
};

}  // namespace zygoma
