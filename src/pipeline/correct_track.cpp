#include "src/pipeline/correct_track.h"

namespace zygoma {
namespace {

// What evidence is made of; no flow will be looked for.
FaceChart small_chart(const Frame& frame,
                      const std::optional<Similarity>& head,
                      const Mirror& mirror) {
  if (!head) return {};
  const Picture picture = mirror.of(frame);
  FaceChart chart = make_face_chart(picture, mirror.of(*head, picture.size().width));
  chart.pyramid.clear();
  return chart;
}

}  // namespace

void correct_track(const std::vector<Correction>& corrections,
                   TrackedVideo& tracked,
                   StageObserver& observer,
                   const StopQuestion& stop) {
  const int num_frames = static_cast<int>(tracked.contours.size());
  const std::vector<FrameRange> ranges = reach_of(corrections, num_frames);
  if (ranges.empty() || tracked.stopped) return;
  const Stopwatch watch;
  observer.begin("correct", ranges.back().last + 1);
  const Mirror& mirror = tracked.mirror;
  const int width = tracked.info.width_px;
  std::vector<Correction> turned;
  for (const Correction& correction : corrections) turned.push_back(mirror.of(correction, width));
  for (ContourSet& set : tracked.contours) set = mirror.of(std::move(set), width);
  VideoReader reader(tracked.source);
  Frame frame;
  std::vector<FaceChart> charts;
  auto range = ranges.begin();
  for (int k = 0; range != ranges.end() && reader.read_planes(frame); ++k) {
    if (stop && stop()) {
      tracked.stopped = true;
      break;
    }
    observer.update(k + 1);
    if (k < range->first) continue;
    charts.push_back(small_chart(frame, tracked.heads[k], mirror));
    if (k < range->last) continue;
    tracked.contours_corrected +=
        apply_corrections(turned, *range, charts, tracked.lips, tracked.contours);
    charts.clear();
    ++range;
  }
  for (ContourSet& set : tracked.contours) set = mirror.of(std::move(set), width);
  observer.end();
  tracked.figures.total_ms += watch.elapsed_ms();
}

}  // namespace zygoma
