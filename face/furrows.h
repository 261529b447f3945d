// How deep the skin folds where the tissue pushes it together.
//
// A furrow is a millimetre wide, the elements of the lattice are several: the lattice says how much
// shorter the skin becomes, not that it folds. But skin hardly shortens, it buckles, and a sheet
// that keeps its length while its ends come closer by the share e folds into waves of amplitude
//
//   A = (s / pi) sqrt(e - e_0),      e = 1 - |F a|
//
// for a spacing s of the furrows (Cerda and Mahadevan, Geometry and physics of wrinkling, 2003;
// here e is small). a is the direction across the furrows in the skin at rest, F the deformation,
// found from the edges around each vertex, and e_0 what skin takes before it buckles. Where furrows
// lie and how far apart is anatomy (Skin::furrow_sites, Skin::relief); whether and how deep, the
// physics decides.
#pragma once

#include <vector>

#include "face/anatomy.h"

namespace zygoma {

class Furrows {
 public:
  explicit Furrows(const Skin& skin);

  bool empty() const { return sites_.empty(); }

  // A per vertex of the skin in this shape, millimetres; 0 where there is no site.
  void amplitudes(const std::vector<Vec3>& skin_mm, std::vector<float>& amplitude_mm) const;

 private:
  // |sum of weight * (neighbour - vertex)| is the stretch across.
  struct Site {
    int vertex = 0;
    int first = 0;  // into terms_
    int last = 0;
    float spacing_mm = 0.0F;
  };
  struct Term {
    int neighbour = 0;
    float weight = 0.0F;
  };
  std::vector<Site> sites_;
  std::vector<Term> terms_;
  std::vector<int> site_of_;  // per vertex, -1 = none
};

}  // namespace zygoma
