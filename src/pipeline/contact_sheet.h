// Small labelled pictures of one face under many poses, in rows.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "face/facs.h"
#include "face/scene.h"
#include "src/base/stop.h"
#include "src/pipeline/stage_observer.h"
#include "src/render/renderer.h"

namespace zygoma {

struct SheetEntry {
  std::string title;
  std::string caption;
  Pose pose;
};

struct SheetOptions {
  int tile_height_px = 240;
  int num_columns = 8;
  RenderOptions render;
};

// What the poses did that a picture does not show.
struct SheetReport {
  std::vector<std::string> not_converged;  // titles
  std::vector<std::string> inverted;
};

// Settles every pose from rest. Throws InputError naming a muscle that the face does not have. A
// stop leaves the rest of the sheet empty.
cv::Mat contact_sheet(const Scene& scene,
                      const std::shared_ptr<const Anatomy>& anatomy,
                      const std::vector<SheetEntry>& entries,
                      const SheetOptions& options,
                      SheetReport& report,
                      StageObserver& observer,
                      const StopQuestion& stop);

}  // namespace zygoma
