// What long work tells whoever watches it. Called from the thread that runs the pipeline.
#pragma once

#include <string_view>

namespace zygoma {

class Progress {
 public:
  virtual ~Progress() = default;
  // A stage starts; the total is what the container claims, 0 if unknown.
  virtual void begin(std::string_view stage, int about_num_frames) = 0;
  virtual void frame_done() = 0;
  virtual void end() = 0;
};

}  // namespace zygoma
