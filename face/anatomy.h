// The immutable description of one face: everything that does not change while it moves.
//
// `surface` is the mesh from which the lattice is built (its vertices are the epidermis nodes);
// `skin` is the fine mesh that people see, embedded in it. The embedding acts on displacements,
//
//   x_skin = X_skin + sum_j w_j (x_j - X_j),      sum_j w_j = 1,
//
// so that the skin is exactly the authored one at rest.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "face/geometry.h"
#include "face/jaw.h"
#include "face/muscle.h"
#include "src/base/names.h"

namespace zygoma {

// Compressed rows: skin vertex v depends on surface vertices index[begin[v] .. begin[v + 1]).
struct Embedding {
  std::vector<int> begin;
  std::vector<int> index;
  std::vector<float> weight;
};

// 8-bit sRGB picture, row-major from the top.
struct Texture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

// Heights finer than the skin's mesh, texel by texel of the albedo picture; empty = smooth.
struct Relief {
  std::vector<float> detail_mm;  // pores, lines of the lips: always there
  std::vector<float> furrow;     // pattern of the furrows, -1 at their bottom (furrows.h)
};

// How the skin folds at a vertex: perpendicular to `across` (unit, at rest; zero = it does not), in
// furrows `spacing_mm` apart.
struct FurrowSite {
  Eigen::Vector3f across{0.0F, 0.0F, 0.0F};
  float spacing_mm = 0.0F;
};

struct Skin {
  SurfaceMesh mesh;
  std::vector<Eigen::Vector2f> uv;  // into `albedo`, [0, 1], v downwards
  Embedding embedding;
  Texture albedo;
  Relief relief;
  std::vector<FurrowSite> furrow_sites;  // per vertex, or empty
};

enum class Bone : std::uint8_t { kSkull, kMandible };

// Eyeballs, teeth, the dark of the mouth: move rigidly with a bone.
struct RigidPart {
  std::string name;
  Bone bone = Bone::kSkull;
  SurfaceMesh mesh;
  std::vector<Eigen::Vector3f> albedo;  // linear RGB per vertex
  float gloss = 0.0F;                   // [0, 1]
};

// Outer face of a row of teeth with the jaw closed: in plan a superellipse,
//
//   (x / half_width)^2 + (max(0, z - back) / depth)^2.5 = 1,    back = front_z - depth,
//
// which reaches from the cutting edges as far as `height` up (upper row) or down (lower row).
struct DentalArch {
  double half_width_mm = 0.0;
  double depth_mm = 0.0;
  double front_z_mm = 0.0;
  double edge_y_mm = 0.0;
  double height_mm = 0.0;
};

struct Teeth {
  DentalArch upper;  // of the skull
  DentalArch lower;  // of the mandible
};

// A curve of the skin that a contour of the same name (tracker/feature_schema.h) observes; chain of
// skin vertices in the order of the schema.
struct NamedCurve {
  std::string name;
  std::vector<int> skin_vertices;
};

// Which flap of skin a surface vertex belongs to: a muscle of the upper lip must not drag the
// lower.
enum class Region : std::uint8_t { kFace, kUpperLip, kLowerLip, kUpperLid, kLowerLid };

struct Anatomy {
  SurfaceMesh surface;
  std::vector<double> tissue_depth_mm;  // per surface vertex: skin to bone along the inward normal
  std::vector<double> mandible_weight;  // per surface vertex: share of the jaw's motion of the bone
                                        // below it, [0, 1]
  std::vector<Region> region;           // per surface vertex
  std::vector<char> cut_off;            // per surface vertex: the surface ends here, but the tissue
                                        // it stands for goes on; empty = nowhere
  std::vector<Muscle> muscles;
  Jaw jaw;
  Skin skin;
  std::vector<RigidPart> rigid_parts;
  std::optional<Teeth> teeth;  // that lips may touch
  std::vector<NamedCurve> curves;

  // Index of the muscle of that name, or -1.
  int muscle_index(std::string_view name) const { return find_name(muscles, name); }

  std::vector<std::string> muscle_names() const {
    std::vector<std::string> names;
    names.reserve(muscles.size());
    for (const Muscle& muscle : muscles) names.push_back(muscle.name);
    return names;
  }
};

}  // namespace zygoma
