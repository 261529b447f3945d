// For stages that are run without anybody watching.
#pragma once

#include <string>

#include "src/pipeline/stage_observer.h"

namespace zygoma {

class SilentObserver : public StageObserver {
 public:
  void begin(const std::string&, int) override {}
  void update(int) override {}
  void end() override {}
};

}  // namespace zygoma
