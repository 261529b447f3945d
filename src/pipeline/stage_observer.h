// What long work tells whoever watches it. Called from the thread that runs the pipeline.
#pragma once

#include <string>

namespace zygoma {

class StageObserver {
 public:
  virtual ~StageObserver() = default;
  // A stage of about that many frames starts; 0 when nobody knows (container claims are hints).
  virtual void begin(const std::string& stage, int about_num_frames) = 0;
  // That many frames of the stage are complete.
  virtual void update(int num_done) = 0;
  virtual void end() = 0;
};

}  // namespace zygoma
