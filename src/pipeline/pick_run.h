// Which level of quality brings a whole run within a budget of time.
//
// The clip is tracked first, so its motion is known; then a level is tried on the second of it that
// moves most like the whole: estimated, settled, drawn and encoded. What that takes per frame, and
// what it takes to begin, says what the rest of the run will take,
//
//   run = what has passed until now + begin + frames * per frame,
//
// and levels are tried upwards or downwards until the most accurate one that fits is found. What
// the trials take counts as part of the run.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "src/base/stop.h"
#include "src/pipeline/animate_face.h"
#include "src/pipeline/run_quality.h"

namespace zygoma {

// The faces of a run, ready to move.
struct RunFaces {
  std::shared_ptr<const Anatomy> anatomy;  // of the face that is drawn
  std::unique_ptr<Simulator> drawn;
  std::unique_ptr<Simulator> other;  // of the estimation, where that is another one
  FaceResponse response;             // of the estimation's

  Simulator& estimation() { return other ? *other : *drawn; }
};

// When `stop` says so what comes back is of no use.
RunFaces prepare_faces(const RunQuality& quality, const StopQuestion& stop = {});

// What is to be done with a tracked clip, whatever the quality.
struct RunTask {
  const TrackedVideo& tracked;
  RetargetOptions estimation;
  const PerformerProfile* profile = nullptr;
  std::function<AnimateOptions(const RunQuality&)> drawing;
  std::string scratch;  // a video that may be written and is removed again
  StopQuestion stop;    // what comes back after it said so is of no use
};

struct RunCost {
  double begin_ms = 0.0;
  double frame_ms = 0.0;

  double total_ms(std::size_t num_frames) const {
    return begin_ms + frame_ms * static_cast<double>(num_frames);
  }
};

// Estimation, settling, drawing and encoding of the clip, on the wall.
RunCost try_quality(const RunQuality& quality, RunFaces& faces, const RunTask& task);

struct RunPick {
  std::size_t quality = 0;  // of run_qualities()
  RunFaces faces;
  double expected_ms = 0.0;  // per frame, of the whole run from its start to its end; above the
                             // budget where not even the quickest fits
};

// How much slower tracking is than where levels were measured: as a first guess everything is.
double slowness(const TrackedVideo& tracked);

// The level that will probably fit on a machine that much slower, `passed_ms` after the run began;
// without them before anything is done on a usual one. num_frames 0: nobody knows.
std::size_t guess_quality(double budget_ms,
                          std::size_t num_frames,
                          double slower = 1.0,
                          std::optional<double> passed_ms = {});

// `passed_ms`: since the run began. `draft` are the faces of the quickest level.
RunPick pick_for_run(double budget_ms,
                     RunFaces draft,
                     const RunTask& task,
                     const std::function<double()>& passed_ms);

// The same decision with the trials given: what level k costs. The pick comes without faces.
RunPick pick_by_trials(double budget_ms,
                       std::size_t guess,
                       std::size_t num_frames,
                       const std::function<RunCost(std::size_t)>& cost_of,
                       const std::function<double()>& passed_ms);

// The quickest level whose skin is expected to be within tolerance_mm (RMS) of the reference; the
// reference if none is.
std::size_t pick_for_run_tolerance(double tolerance_mm);

}  // namespace zygoma
