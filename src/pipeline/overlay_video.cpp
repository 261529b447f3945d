#include "src/pipeline/overlay_video.h"

#include "src/io/video_reader.h"
#include "src/io/video_writer.h"
#include "src/pipeline/overlay.h"

namespace zygoma {

StageFigures write_overlay_video(const VideoSource& source,
                                 const std::vector<ContourSet>& contours,
                                 const std::string& output,
                                 StageObserver& observer,
                                 const StopQuestion& stop) {
  VideoReader reader(source);
  const VideoInfo& info = reader.info();
  VideoWriter writer(output, info.width_px, info.height_px, info.average_frames_per_s);
  observer.begin("overlay", static_cast<int>(contours.size()));
  const Stopwatch watch;
  int num_done = 0;
  Frame frame;
  while (num_done < static_cast<int>(contours.size()) && reader.read(frame)) {
    draw_contours(contours[num_done], 1.0, frame.image);
    writer.write(frame.image, frame.time_s);
    observer.update(++num_done);
    if (stop && stop()) break;
  }
  writer.finish();
  observer.end();
  return {"overlay", num_done, watch.elapsed_ms()};
}

}  // namespace zygoma
