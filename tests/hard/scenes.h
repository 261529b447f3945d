// Faces, tissues and controls that the hard cases share.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "face/facs.h"
#include "face/generic_head.h"
#include "face/prism.h"
#include "face/simulator.h"
#include "tests/support/derivatives.h"
#include "tests/support/face_patch.h"

namespace zygoma::hard {

using test_support::FacePatchOptions;
using test_support::make_face_patch;
using test_support::Random;

// About 110 surface vertices: coarse, but with everything a face has.
inline FacePatchOptions small_patch() {
  FacePatchOptions options;
  options.half_columns = 5;
  options.row_mm = 16.0;
  options.rows_below_mouth = 2;
  options.rows_above_mouth = 8;
  return options;
}

// About 290.
inline FacePatchOptions coarse_patch() {
  FacePatchOptions options;
  options.half_columns = 8;
  options.row_mm = 11.0;
  options.rows_below_mouth = 4;
  options.rows_above_mouth = 12;
  return options;
}

inline std::shared_ptr<const Anatomy> shared(Anatomy anatomy) {
  return std::make_shared<const Anatomy>(std::move(anatomy));
}

// The default head without the picture on its skin.
inline std::shared_ptr<const Anatomy> generic_head(int num_surface_vertices) {
  return shared(make_generic_head({}, {num_surface_vertices, 0, 64}));
}

struct Tissue {
  std::string name;
  TissueModel model;
};

inline std::vector<Tissue> topologies() {
  std::vector<Tissue> all{
      {"prisms, three layers", {}}, {"prisms, two layers", {}}, {"centroids", {}}};
  all[1].model.lattice.layers = bi_layer();
  all[2].model.lattice.topology = Topology::kCentroids;
  return all;
}

inline Controls at_rest(const Anatomy& anatomy) {
  return {std::vector<double>(anatomy.muscles.size(), 0.0), 0.0};
}

struct Pull {
  std::string muscle;  // of both sides
  double contraction = 0.0;
};

inline Controls with(const Anatomy& anatomy, const std::vector<Pull>& pulls, double jaw_rad = 0.0) {
  Controls controls = at_rest(anatomy);
  for (const Pull& pull : pulls) {
    for (const char* side : {"_L", "_R"}) {
      controls.contraction.at(anatomy.muscle_index(pull.muscle + side)) = pull.contraction;
    }
  }
  controls.jaw_rad = jaw_rad;
  return controls;
}

inline Controls smile(const Anatomy& anatomy, double contraction) {
  return with(anatomy, {{"zygomaticus_major", contraction}});
}

// About a third of the muscles, contractions 0 to `strongest`, jaw 0 to 0.2 rad.
inline Controls random_controls(const Anatomy& anatomy, double strongest, Random& random) {
  Controls controls = at_rest(anatomy);
  for (double& c : controls.contraction) {
    const bool takes_part = random.next() < -1.0 / 3.0;
    c = takes_part ? 0.5 * strongest * (1.0 + random.next()) : 0.0;
  }
  controls.jaw_rad = 0.1 * (1.0 + random.next());
  return controls;
}

// The six basic expressions.
inline std::vector<Expression> basic_expressions() {
  std::vector<Expression> basic;
  for (const char* name : {"happiness", "sadness", "surprise", "fear", "anger", "disgust"}) {
    for (const Expression& expression : expressions()) {
      if (expression.name == name) basic.push_back(expression);
    }
  }
  return basic;
}

inline double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

// Relative volumes of all elements.
inline std::vector<double> relative_volumes(const Lattice& lattice, const std::vector<Vec3>& x) {
  std::vector<double> volumes;
  for (const Prism& prism : lattice.prisms) {
    volumes.push_back(signed_volume(prism, x) / prism.rest_mm3);
  }
  return volumes;
}

// "prism 12 (nodes 3 4 9 | 40 41 46)" of the first few elements that are inside out.
inline std::string inverted_elements(const Lattice& lattice, const std::vector<Vec3>& x) {
  constexpr int kMostNamed = 4;
  const std::vector<double> volumes = relative_volumes(lattice, x);
  std::string text;
  int named = 0;
  for (std::size_t p = 0; p < volumes.size() && named < kMostNamed; ++p) {
    if (volumes[p] >= 0.0) continue;
    text += (named++ > 0 ? ", " : "") + std::string("prism ") + std::to_string(p) + " at column " +
            std::to_string(lattice.column_of[lattice.prisms[p].node[0]]);
  }
  return text;
}

}  // namespace zygoma::hard
