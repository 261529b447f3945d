#include "face/tissue_hessian.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <set>

namespace zygoma {

TissueHessian::TissueHessian(const Lattice& lattice, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<std::vector<int>> nodes(lattice.columns.size());
  std::vector<int> place(lattice.num_free_nodes);  // of a node in its column
  for (std::size_t c = 0; c < nodes.size(); ++c) {
    for (const int node : lattice.columns[c].nodes) {
      if (!lattice.is_free(node)) continue;
      place[node] = static_cast<int>(nodes[c].size());
      nodes[c].push_back(node);
    }
  }
  std::set<std::array<int, 2>> coupled;
  for (const auto& [a, b] : pairs) {
    if (!lattice.is_free(a) || !lattice.is_free(b)) continue;
    const auto [first, second] = std::minmax(lattice.column_of[a], lattice.column_of[b]);
    if (first != second) coupled.insert({first, second});
  }
  free_.reset(std::move(nodes), {coupled.begin(), coupled.end()});

  std::map<std::array<int, 2>, std::size_t> bone_blocks;
  slots_.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    Slot slot;
    if (lattice.is_free(a) && lattice.is_free(b)) {
      int row = a;
      int column = b;
      const int ca = lattice.column_of[a];
      const int cb = lattice.column_of[b];
      // Lower blocks only: the row is in the later column, or further down in the same one.
      const bool turned = std::pair(ca, place[a]) < std::pair(cb, place[b]);
      if (turned) std::swap(row, column);
      std::size_t block = ca;
      if (ca != cb) {
        const std::array<int, 2> edge{std::min(ca, cb), std::max(ca, cb)};
        const auto at = std::lower_bound(free_.edges.begin(), free_.edges.end(), edge);
        block = free_.num_columns() + (at - free_.edges.begin());
      }
      slot.stride = free_.rows(lattice.column_of[row]);
      slot.at = free_.begin[block] + 3 * place[column] * slot.stride + 3 * place[row];
      slot.kind = turned ? Kind::kFreeTransposed : Kind::kFree;
    } else if (lattice.is_free(a) || lattice.is_free(b)) {
      const bool turned = !lattice.is_free(a);
      const std::array<int, 2> ends = turned ? std::array<int, 2>{b, a} : std::array<int, 2>{a, b};
      const auto [at, fresh] = bone_blocks.try_emplace(ends, bone_.size());
      if (fresh) bone_.push_back({ends[0], ends[1], Eigen::Matrix3d::Zero()});
      slot.at = at->second;
      slot.kind = turned ? Kind::kBoneTransposed : Kind::kBone;
    }
    slots_.push_back(slot);
  }
}

void TissueHessian::set_zero() {
  free_.set_zero();
  for (BoneBlock& block : bone_) block.value.setZero();
  next_ = 0;
}

void TissueHessian::add(int /*a*/, int /*b*/, const Eigen::Matrix3d& piece) {
  assert(next_ < slots_.size());
  const Slot& slot = slots_[next_++];
  switch (slot.kind) {
    case Kind::kNone:
      break;
    case Kind::kFree:
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) free_.values[slot.at + c * slot.stride + r] += piece(r, c);
      }
      break;
    case Kind::kFreeTransposed:
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) free_.values[slot.at + c * slot.stride + r] += piece(c, r);
      }
      break;
    case Kind::kBone:
      bone_[slot.at].value += piece;
      break;
    case Kind::kBoneTransposed:
      bone_[slot.at].value += piece.transpose();
      break;
  }
}

}  // namespace zygoma
