// Follows the nine contours through a video, frame by frame: predict, relax, judge, recover
// (paper, section 6, with the corrections of docs/tracking.md).
#pragma once

#include <memory>
#include <string>

#include "tracker/contour_set.h"
#include "tracker/frame.h"

namespace zygoma {

struct TrackerOptions {
  std::string cascade_folder;  // OpenCV's haarcascades; empty: the places where packages put them
  // Further options belong here: inline default, unit, range, what goes wrong at the extremes.

  // Throws InputError naming the first value outside its range.
  void check() const;
};

// How the last frame went; data, never an exception.
struct TrackReport {
  bool face_found = false;
  int num_lost = 0;          // contours without a position in this frame
  int relax_iterations = 0;  // summed over contours
};

class Tracker {
 public:
  explicit Tracker(const TrackerOptions& options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  // Uses these contours instead of the automatic start on the next frame. Contours that are
  // missing are placed by the template fitted to those given.
  void start_from(const ContourSet& initial);

  // The contours of the next frame. Until a face is found, a set whose contours are all lost.
  ContourSet track(const Frame& frame);

  const TrackReport& report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace zygoma
