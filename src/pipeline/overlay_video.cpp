#include "src/pipeline/overlay_video.h"

#include "src/io/video_writer.h"
#include "src/pipeline/overlay_view.h"
#include "src/pipeline/producer.h"

namespace zygoma {

StageFigures write_overlay_video(const TrackedVideo& tracked,
                                 const std::string& output,
                                 StageObserver& observer,
                                 const StopQuestion& stop) {
  VideoReader reader(tracked.source);
  const VideoInfo& info = reader.info();
  const int num_frames = static_cast<int>(tracked.contours.size());
  OverlayView view({info.width_px, info.height_px}, tracked.contours, tracked.heads);
  VideoWriter writer(
      output, view.size_px().width, view.size_px().height, info.average_frames_per_s);
  observer.begin("overlay", num_frames);
  const Stopwatch watch;
  int num_done = 0;
  Producer<Frame> frames(2, [&]() -> std::optional<Frame> {
    Frame frame;
    if (!reader.read(frame)) return std::nullopt;
    return frame;
  });
  while (num_done < num_frames) {
    const std::optional<Frame> frame = frames.next();
    if (!frame) break;
    writer.write(view.draw(num_done, frame->image), frame->time_s);
    observer.update(++num_done);
    if (stop && stop()) break;
  }
  writer.finish();
  observer.end();
  return {"overlay", num_done, watch.elapsed_ms()};
}

}  // namespace zygoma
