// The nine facial features of Waters & Terzopoulos 1992, section 6, and the upper eyelids: their
// names, how many nodes their contours have and in which order the nodes run. Left and right are
// the subject's.
//
// The names are the whole contract between tracker and face: the anatomy names its surface curves
// alike, and retarget joins the two by name and arc length.
#pragma once

#include <array>
#include <span>
#include <string_view>

namespace zygoma {

struct Feature {
  std::string_view name;
  int num_nodes;
};

// Node order: brows from the inner to the outer end along the upper edge of the brow; lips (outer
// border, ends at the mouth corners), hairline and chin from the subject's right to left; furrows
// from top to bottom; the nose tip from the subject's right to left along the base of the nose;
// eyelids along the margin of the upper lid from the inner to the outer corner.
inline constexpr std::array<Feature, 11> kFeatureSchema{{
    {"brow_left", 9},
    {"brow_right", 9},
    {"furrow_left", 9},
    {"furrow_right", 9},
    {"nose_tip", 9},
    {"upper_lip", 13},
    {"lower_lip", 13},
    {"chin_boss", 9},
    {"hairline", 13},
    {"eyelid_left", 9},
    {"eyelid_right", 9},
}};

// The nine of the paper, from which it estimates contractions. Of the eyelids the corners hold the
// head and what is between them shows the muscles of the lid.
inline constexpr std::span<const Feature> kContours1992(kFeatureSchema.data(), 9);

}  // namespace zygoma
