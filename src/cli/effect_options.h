// --with, --without and --effects: effects turned on and off from the command line, or left to the
// program.
#pragma once

#include <string>
#include <vector>

#include "face/scene.h"
#include "src/cli/command.h"

namespace zygoma {

class EffectOptions {
 public:
  void declare(OptionSink& options);

  // First takes away, then adds: parameters given replace those that an effect of the scene has.
  // Throws InputError naming the option and what is wrong with it.
  void apply(std::vector<EffectChoice>& effects) const;

  // The same, and --effects: which are there by need.
  void apply(Scene& scene) const;
  void declare_choice(OptionSink& options);

 private:
  std::string effects_ = "scene";
  double tolerance_mm_ = SettleOptions::kUsualChooseMm;
  std::vector<std::string> with_;
  std::vector<std::string> without_;
};

}  // namespace zygoma
