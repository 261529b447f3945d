// The fine skin over a surface: subdivided domain, embedding weights, named curves.
#pragma once

#include <vector>

#include "face/anatomy.h"
#include "face/head_mesh.h"

namespace zygoma {

struct FineSkin {
  DomainMesh domain;
  Embedding embedding;
};

FineSkin refine(const HeadShape& shape, const DomainMesh& surface, int levels);

// Chains of fine vertices for every name of tracker/feature_schema.h; vertices near a curve are
// moved onto it (in the domain) first.
std::vector<NamedCurve> lay_curves(const HeadShape& shape, DomainMesh& fine);

}  // namespace zygoma
