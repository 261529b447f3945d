// The second derivatives of the tissue's energy as matrices: among the free nodes, and between free
// nodes and bone.
//
// Terms add 3 x 3 pieces in a fixed order (energy_term.h). The pattern is recorded once, and the
// place of the k-th piece with it, so that assembling is one pass without searching.
#pragma once

#include <cstdint>
#include <vector>

#include "face/energy_term.h"
#include "face/lattice.h"
#include "face/solvers/column_matrix.h"

namespace zygoma {

class TissueHessian final : public HessianSink {
 public:
  struct BoneBlock {
    int free_node = 0;
    int bone_node = 0;
    Eigen::Matrix3d value;  // d2(energy) / d(free) d(bone)
  };

  // `pairs`: the nodes of all pieces, in the order in which they will be added.
  TissueHessian(const Lattice& lattice, const std::vector<std::array<int, 2>>& pairs);

  void set_zero();
  void add(int a, int b, const Eigen::Matrix3d& piece) override;
  void skip(std::size_t num_pieces) override { next_ += num_pieces; }

  const ColumnMatrix& free() const { return free_; }
  const std::vector<BoneBlock>& bone() const { return bone_; }

 private:
  enum class Kind : std::uint8_t { kNone, kFree, kFreeTransposed, kBone, kBoneTransposed };
  struct Slot {
    std::size_t at = 0;
    int stride = 0;
    Kind kind = Kind::kNone;
  };
  ColumnMatrix free_;
  std::vector<BoneBlock> bone_;
  std::vector<Slot> slots_;
  std::size_t next_ = 0;
};

// Records the pairs of nodes of what is added.
class PatternRecorder final : public HessianSink {
 public:
  void add(int a, int b, const Eigen::Matrix3d& /*piece*/) override { pairs.push_back({a, b}); }
  std::vector<std::array<int, 2>> pairs;
};

// How many pieces come.
class PieceCounter final : public HessianSink {
 public:
  void add(int /*a*/, int /*b*/, const Eigen::Matrix3d& /*piece*/) override { ++num_pieces; }
  void skip(std::size_t num) override { num_pieces += num; }
  std::size_t num_pieces = 0;
};

}  // namespace zygoma
