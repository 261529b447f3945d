// The order in which the columns of a lattice are eliminated, and which of them together.
//
// A graph partitioner's fill-reducing order gives the elimination tree; columns that have nearly
// the same later neighbours are then merged into one front, because a few stored zeros cost less
// than another small dense matrix. Which merges pay is a matter of time per solve: reading the
// zeros twice against handling one front and its list of later rows.
#pragma once

#include <vector>

namespace zygoma {

// Columns eliminated together.
struct FrontColumns {
  int parent = -1;
  std::vector<int> own;
  std::vector<int> rest;  // eliminated later and touched by this front, in order of elimination
};

// `neighbors` and `weights` (unknowns) per column. Children come before their parents.
std::vector<FrontColumns> plan_elimination(const std::vector<std::vector<int>>& neighbors,
                                           const std::vector<int>& weights);

}  // namespace zygoma
