#include "src/pipeline/run_quality.h"

#include <array>

#include "src/base/check.h"

namespace zygoma {

void RunQuality::apply(RetargetOptions& options) const {
  options.refine = refine;
  options.level = level;
}

bool RunQuality::has_one_face() const {
  return face.surface_vertices == estimation.surface_vertices &&
         face.bi_layer == estimation.bi_layer &&
         face.relative_residual == estimation.relative_residual;
}

const std::vector<RunQuality>& run_qualities() {
  struct Work {
    SecondLooks second_looks;
    bool refine;
    FaceLevel level;
  };
  constexpr Work kClosedForm{SecondLooks::kNone, false, FaceLevel::kLinear};
  constexpr Work kLinear{SecondLooks::kNone, true, FaceLevel::kLinear};
  constexpr Work kCorrected{SecondLooks::kStart, true, FaceLevel::kCorrected};
  constexpr Work kLattice{SecondLooks::kStart, true, FaceLevel::kLattice};
  constexpr Work kEverything{SecondLooks::kAll, true, FaceLevel::kLattice};
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
                      work.refine,
                      work.level,
                      figures[0],
                      figures[1],
                      figures[2]};
  };
  const char* const coarser = "between standard and fine";
  const char* const finer = "between fine and reference";
  static const std::vector<RunQuality> qualities{
      level("draft", "draft", "draft", kClosedForm, {0.131, 800.0, 24.0}),
      level("between draft and standard", "draft", "draft", kLinear, {0.074, 800.0, 26.0}),
      level("standard", "standard", "standard", kCorrected, {0.064, 1000.0, 30.0}),
      level(coarser, coarser, coarser, kCorrected, {0.063, 1200.0, 37.0}),
      level("fine", "fine", "fine", kCorrected, {0.061, 2500.0, 60.0}),
      level(finer, finer, "fine", kLattice, {0.060, 3000.0, 100.0}),
      level("reference", "reference", finer, kEverything, {0.059, 7000.0, 400.0})};
  return qualities;
}

const RunQuality& run_quality(const std::string& name) {
  std::string known;
  for (const RunQuality& quality : run_qualities()) {
    if (quality.name == name) return quality;
    known += (known.empty() ? "" : ", ") + quality.name;
  }
  throw InputError("quality \"" + name + "\" is unknown, expected one of " + known);
}

}  // namespace zygoma
