// A stretch of frames followed once more, backwards, from where the tracker has come to.
//
// Following from the first frame on, the tracker knows least at the start: the picture is often
// blocky, the contours come from a search, and nothing has yet been seen of how this face moves. At
// the end of the stretch it knows more. So a copy of it, its earlier looks forgotten, goes back
// over the frames kept, and both tracks are blended by how far each has come:
//   first stretch       the weight of the backward track falls from one to zero,
//   any later stretch   it is one half, with ramps at both ends where the stretches join.
// A contour that only one of the two saw is taken from that one. Where they disagree by d pixels
// the confidence is divided by 1 + (d / tolerance)^2. At a cut the copy stops.
//
// Frames are kept within a bound of memory, whatever the length of the clip.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tracker/tracker.h"

namespace zygoma {

struct SecondLookOptions {
  // Frames of a stretch, [2, 1000]. Small: the start is mended little; large: the start waits long
  // and memory is the limit.
  int num_frames = 48;
  size_t memory_bytes = size_t{96} << 20;  // of the pictures kept; shortens the stretch
  // Disagreement that halves the confidence, eye distances, > 0.
  double tolerance_iod = 0.06;

  // Contours that somebody gave for the first frame are trusted: the first stretch is as any later.
  bool start_is_given = false;

  // Throws InputError naming the first value outside its range.
  void check() const;
};

class SecondLook {
 public:
  explicit SecondLook(const SecondLookOptions& options = {});

  // Keeps the picture of the frame that was just tracked: a copy, or its planes.
  void add(const Frame& frame);
  bool full() const;

  // Follows the frames kept backwards with a copy of `tracker`, which has just seen the last of
  // them, and blends the result into the last of `contours`; heads (image from chart) that were
  // missing are filled in. The stretch ends here.
  void look(const Tracker& tracker,
            std::vector<ContourSet>& contours,
            std::vector<std::optional<Similarity>>& heads);

 private:
  SecondLookOptions options_;
  std::vector<Frame> frames_;
  bool first_stretch_;
};

}  // namespace zygoma
