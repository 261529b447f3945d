#include "src/pipeline/run_quality.h"

#include <array>

#include "src/base/names.h"

namespace zygoma {

void RunQuality::apply(RetargetOptions& options) const { options.level = level; }

bool RunQuality::has_one_face() const {
  return face.surface_vertices == estimation.surface_vertices &&
         face.bi_layer == estimation.bi_layer &&
         face.relative_residual == estimation.relative_residual;
}

const std::vector<RunQuality>& run_qualities() {
  struct Work {
    SecondLooks second_looks;
    FaceLevel level;
    int samples_per_pixel;
  };
  constexpr Work kLinear{SecondLooks::kNone, FaceLevel::kLinear, 1};
  constexpr Work kCorrected{SecondLooks::kStart, FaceLevel::kCorrected, 2};
  constexpr Work kLattice{SecondLooks::kStart, FaceLevel::kLattice, 2};
  constexpr Work kEverything{SecondLooks::kAll, FaceLevel::kLattice, 2};
  // Name, faces that are drawn and estimated with, RMS, ms to start and per frame.
  const auto level = [](const char* name,
                        const char* drawn,
                        const char* estimated_with,
                        const Work& work,
                        const std::array<double, 3>& figures) {
    return RunQuality{name,
                      face_quality(drawn),
                      face_quality(estimated_with),
                      work.second_looks,
                      work.level,
                      work.samples_per_pixel,
                      figures[0],
                      figures[1],
                      figures[2]};
  };
  const char* const coarser = "between standard and fine";
  const char* const finer = "between fine and reference";
  static const std::vector<RunQuality> qualities{
      level("draft", "draft", "draft", kLinear, {0.067, 600.0, 20.0}),
      level("standard", "standard", "standard", kCorrected, {0.055, 600.0, 26.0}),
      level(coarser, coarser, coarser, kCorrected, {0.057, 1100.0, 32.0}),
      level("fine", "fine", "fine", kCorrected, {0.057, 2400.0, 41.0}),
      level(finer, finer, "fine", kLattice, {0.057, 3500.0, 92.0}),
      level("reference", "reference", finer, kEverything, {0.056, 7400.0, 272.0})};
  return qualities;
}

const RunQuality& run_quality(const std::string& name) {
  return run_qualities()[require_name("quality", run_qualities(), name)];
}

}  // namespace zygoma
