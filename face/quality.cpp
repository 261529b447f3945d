#include "face/quality.h"

#include "src/base/names.h"

namespace zygoma {

void FaceQuality::apply(HeadOptions& head, TissueModel& tissue, SettleOptions& settle) const {
  head.num_surface_vertices = surface_vertices;
  tissue.lattice.layers = bi_layer ? zygoma::bi_layer() : tri_layer();
  settle.relative_residual = relative_residual;
}

const std::vector<FaceQuality>& face_qualities() {
  static const std::vector<FaceQuality> qualities{
      {"draft", 300, true, 1e-2, 0.74},
      {"standard", 500, true, 1e-2, 0.60},
      {"between standard and fine", 1000, true, 1e-2, 0.42},
      {"fine", 2000, true, 1e-4, 0.25},
      {"between fine and reference", 2000, false, 1e-4, 0.21},
      {"reference", 4000, false, 1e-6, 0.0}};
  return qualities;
}

const FaceQuality& face_quality(const std::string& name) {
  return face_qualities()[require_name("quality", face_qualities(), name)];
}

}  // namespace zygoma
