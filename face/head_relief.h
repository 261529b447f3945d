// The relief of the default head's skin: pores and the lines of the lips, and where it furrows.
//
// Furrows lie where people have them (forehead, between the brows, root and sides of the nose,
// outer corners of the eyes, below the eyes, from nose and mouth downwards, above the chin). They
// are authored as lines of the frontal picture with a spacing each; furrows.h says how deep they
// become.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/head_mesh.h"
#include "face/head_shape.h"

namespace zygoma {

Relief carve_relief(const HeadShape& shape, const Identity& identity, int size_px);

// One per point of the fine skin; `lifted` are their places.
std::vector<FurrowSite> lay_furrows(const HeadShape& shape,
                                    const DomainMesh& fine,
                                    const SurfaceMesh& lifted);

}  // namespace zygoma
