// --with and --without: effects turned on and off from the command line.
#pragma once

#include <string>
#include <vector>

#include "face/effect.h"
#include "src/cli/command.h"

namespace zygoma {

class EffectOptions {
 public:
  void declare(OptionSink& options);

  // First takes away, then adds: parameters given replace those that an effect of the scene has.
  // Throws InputError naming the option and what is wrong with it.
  void apply(std::vector<EffectChoice>& effects) const;

 private:
  std::vector<std::string> with_;
  std::vector<std::string> without_;
};

}  // namespace zygoma
