#include "src/pipeline/run_quality.h"

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
  constexpr bool kRefined = true;
  const auto face = [](const char* name) { return face_quality(name); };
  static const std::vector<RunQuality> qualities{{"draft",
                                                  face("draft"),
                                                  face("draft"),
                                                  SecondLooks::kNone,
                                                  !kRefined,
                                                  FaceLevel::kLinear,
                                                  0.121,
                                                  350.0,
                                                  20.0},
                                                 {"between draft and standard",
                                                  face("draft"),
                                                  face("draft"),
                                                  SecondLooks::kNone,
                                                  kRefined,
                                                  FaceLevel::kLinear,
                                                  0.076,
                                                  350.0,
                                                  23.0},
                                                 {"standard",
                                                  face("standard"),
                                                  face("standard"),
                                                  SecondLooks::kStart,
                                                  kRefined,
                                                  FaceLevel::kCorrected,
                                                  0.064,
                                                  500.0,
                                                  30.0},
                                                 {"between standard and fine",
                                                  face("between standard and fine"),
                                                  face("between standard and fine"),
                                                  SecondLooks::kStart,
                                                  kRefined,
                                                  FaceLevel::kCorrected,
                                                  0.063,
                                                  900.0,
                                                  40.0},
                                                 {"fine",
                                                  face("fine"),
                                                  face("fine"),
                                                  SecondLooks::kStart,
                                                  kRefined,
                                                  FaceLevel::kCorrected,
                                                  0.061,
                                                  2000.0,
                                                  70.0},
                                                 {"between fine and reference",
                                                  face("between fine and reference"),
                                                  face("fine"),
                                                  SecondLooks::kStart,
                                                  kRefined,
                                                  FaceLevel::kLattice,
                                                  0.060,
                                                  2500.0,
                                                  130.0},
                                                 {"reference",
                                                  face("reference"),
                                                  face("between fine and reference"),
                                                  SecondLooks::kAll,
                                                  kRefined,
                                                  FaceLevel::kLattice,
                                                  0.060,
                                                  6000.0,
                                                  400.0}};
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
