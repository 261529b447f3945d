#include "face/solvers/factor.h"

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <array>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "face/energy.h"
#include "face/solvers/dense_kernels.h"
#include "tests/support/derivatives.h"
#include "tests/support/face_patch.h"

namespace zygoma {
namespace {

using Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

void fill_with_random_values(ColumnMatrix& h, double diagonal, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& value : h.values) value = uniform(engine);
  for (int c = 0; c < h.num_columns(); ++c) {
    const int rows = h.rows(c);
    for (int r = 0; r < rows; ++r) h.values[h.begin[c] + r * (rows + 1)] = diagonal;
  }
}

// A sheet of columns with one to four free nodes each, coupled along edges and one diagonal, with
// random values; the diagonal dominates. Nodes are numbered layer by layer, as in a lattice.
ColumnMatrix make_sheet(int width, int height, unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<std::vector<int>> nodes(width * height);
  std::vector<int> depth(nodes.size());
  for (int& d : depth) d = 1 + static_cast<int>(engine() % 4);
  int next = 0;
  for (int layer = 0; layer < 4; ++layer) {
    for (std::size_t c = 0; c < nodes.size(); ++c) {
      if (layer < depth[c]) nodes[c].push_back(next++);
    }
  }
  std::vector<std::array<int, 2>> edges;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int c = y * width + x;
      if (x + 1 < width) edges.push_back({c, c + 1});
      if (y + 1 < height) edges.push_back({c, c + width});
      if (x + 1 < width && y + 1 < height) edges.push_back({c, c + width + 1});
    }
  }
  ColumnMatrix h;
  h.reset(std::move(nodes), std::move(edges));
  fill_with_random_values(h, 40.0, seed);
  return h;
}

// What the blocks mean, entry by entry: the oracle's matrix. Columns that are not active become
// rows of the identity.
Sparse to_sparse(const ColumnMatrix& h, double shift, const std::vector<char>& active) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto unknown = [&](int column, int r) { return 3 * h.nodes[column][r / 3] + r % 3; };
  for (int c = 0; c < h.num_columns(); ++c) {
    for (int j = 0; j < h.rows(c); ++j) {
      if (!active[c]) {
        entries.emplace_back(unknown(c, j), unknown(c, j), 1.0);
        continue;
      }
      entries.emplace_back(unknown(c, j), unknown(c, j), h.diagonal(c)(j, j) + shift);
      for (int i = j + 1; i < h.rows(c); ++i) {
        entries.emplace_back(unknown(c, i), unknown(c, j), h.diagonal(c)(i, j));
        entries.emplace_back(unknown(c, j), unknown(c, i), h.diagonal(c)(i, j));
      }
    }
  }
  for (std::size_t e = 0; e < h.edges.size(); ++e) {
    const auto [first, second] = h.edges[e];
    if (!active[first] || !active[second]) continue;
    for (int j = 0; j < h.rows(first); ++j) {
      for (int i = 0; i < h.rows(second); ++i) {
        entries.emplace_back(unknown(second, i), unknown(first, j), h.edge(e)(i, j));
        entries.emplace_back(unknown(first, j), unknown(second, i), h.edge(e)(i, j));
      }
    }
  }
  Sparse matrix(h.num_unknowns(), h.num_unknowns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

MatrixXd random_matrix(int rows, int columns, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(engine); });
}

// Right-hand sides of which all but the first are zero in most places, as those of muscles are.
MatrixXd right_hand_sides(const ColumnMatrix& h, int count) {
  MatrixXd b = random_matrix(h.num_unknowns(), count, 7);
  for (int c = 1; c < count; ++c) {
    b.col(c).head(b.rows() / 2).setZero();
    b.col(c).tail(b.rows() / 3).setZero();
  }
  return b;
}

// Of columns in an order, those that are active.
std::vector<int> part_of(const std::vector<int>& columns, const std::vector<char>& active) {
  std::vector<int> part;
  for (const int c : columns) {
    if (active[c]) part.push_back(c);
  }
  return part;
}

class FactorWithKernels : public testing::TestWithParam<const DenseKernels*> {
 protected:
  const DenseKernels& kernels() const { return *GetParam(); }

  void expect_same_solution(const ColumnMatrix& h,
                            double shift,
                            const std::vector<char>& active,
                            int num_right_hand_sides) const {
    const bool all = std::find(active.begin(), active.end(), 0) == active.end();
    Factor factor =
        all ? Factor(h, kernels()) : Factor(h, part_of(Factor(h).columns(), active), kernels());
    ASSERT_TRUE(factor.compute(h, shift));
    MatrixXd b = right_hand_sides(h, num_right_hand_sides);
    MatrixXd x = b;
    factor.solve(x);
    Eigen::VectorXd rough = b.col(0);
    factor.solve_roughly(rough);
    for (int c = 0; c < h.num_columns(); ++c) {
      if (active[c]) continue;
      for (const int node : h.nodes[c]) b.middleRows<3>(3 * node).setZero();
    }
    const Eigen::SimplicialLLT<Sparse> oracle(to_sparse(h, shift, active));
    ASSERT_EQ(oracle.info(), Eigen::Success);
    const MatrixXd expected = oracle.solve(b);
    EXPECT_LT((x - expected).norm(), 1e-13 * expected.norm());
    EXPECT_LT((rough - expected.col(0)).norm(), 2e-6 * expected.col(0).norm());
    for (int c = 0; c < h.num_columns(); ++c) {
      if (active[c]) continue;
      for (const int node : h.nodes[c]) {
        EXPECT_TRUE(x.middleRows<3>(3 * node).isZero(0.0));
        EXPECT_TRUE(rough.segment<3>(3 * node).isZero(0.0));
      }
    }
  }
};

TEST_P(FactorWithKernels, SolvesLikeTheOracleWithColumnsOfDifferentSize) {
  for (const auto& [width, height] :
       {std::array{1, 1}, std::array{2, 1}, std::array{7, 5}, std::array{23, 19}}) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const ColumnMatrix h = make_sheet(width, height, 3);
    const std::vector<char> all(h.num_columns(), 1);
    for (const int count : {1, 2, 3, 7, 12, 20, 27, 60}) expect_same_solution(h, 0.0, all, count);
    expect_same_solution(h, 2.5, all, 1);
  }
}

TEST_P(FactorWithKernels, OneDenseFrontOfAnyHeight) {
  for (int columns = 1; columns <= 30; ++columns) {
    SCOPED_TRACE(columns);
    std::vector<std::vector<int>> nodes(columns);
    for (int node = 0; node < columns * 5 / 3 + 1; ++node) nodes[node % columns].push_back(node);
    std::vector<std::array<int, 2>> edges;
    for (int a = 0; a < columns; ++a) {
      for (int b = a + 1; b < columns; ++b) edges.push_back({a, b});
    }
    ColumnMatrix h;
    h.reset(std::move(nodes), std::move(edges));
    fill_with_random_values(h, 200.0, 11);
    expect_same_solution(h, 0.0, std::vector<char>(columns, 1), 5);
  }
}

TEST_P(FactorWithKernels, LeavesOutColumnsThatAreNotActive) {
  const ColumnMatrix h = make_sheet(17, 15, 5);
  std::vector<char> active(h.num_columns(), 1);
  for (int c = 0; c < h.num_columns(); ++c) {
    // A strip in the middle, which makes two unconnected parts, and some on their own.
    active[c] = c % 17 != 8 && c % 11 != 3;
  }
  expect_same_solution(h, 0.0, active, 1);
  expect_same_solution(h, 0.0, active, 21);
  const Factor whole(h);
  EXPECT_LT(Factor(h, part_of(whole.columns(), active)).size(), whole.size());
}

TEST_P(FactorWithKernels, AGivenOrderIsAsGoodAsOneFound) {
  const ColumnMatrix h = make_sheet(17, 15, 5);
  const Factor whole(h);
  EXPECT_LE(static_cast<double>(Factor(h, whole.columns(), kernels()).size()),
            1.02 * static_cast<double>(whole.size()));
}

TEST_P(FactorWithKernels, SaysWhenTheMatrixIsNotPositiveDefinite) {
  ColumnMatrix h = make_sheet(12, 12, 9);
  Factor factor(h, kernels());
  EXPECT_TRUE(factor.compute(h, 0.0));
  EXPECT_FALSE(factor.compute(h, -1e3));
  // One bad pivot in the last column of the sheet is enough; a large shift mends it.
  h.values[h.begin[h.num_columns() - 1]] = -1.0;
  EXPECT_FALSE(factor.compute(h, 0.0));
  EXPECT_TRUE(factor.compute(h, 60.0));
  h.values[h.begin[40]] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor.compute(h, 0.0));
  h.values[h.begin[40]] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(factor.compute(h, 0.0));
}

TEST_P(FactorWithKernels, SameBitsEveryTimeAndAfterAFailure) {
  const ColumnMatrix good = make_sheet(20, 11, 2);
  ColumnMatrix bad = good;
  bad.values.assign(bad.values.size(), std::numeric_limits<double>::quiet_NaN());
  ColumnMatrix worse = good;
  worse.values[worse.begin[worse.nodes.size() + 200]] = std::numeric_limits<double>::infinity();
  const MatrixXd b = right_hand_sides(good, 9);
  const auto solve = [&](Factor& factor) {
    EXPECT_TRUE(factor.compute(good, 0.0));
    MatrixXd x = b;
    factor.solve(x);
    return x;
  };
  Factor factor(good, kernels());
  const MatrixXd first = solve(factor);
  EXPECT_FALSE(factor.compute(bad, 0.0));
  EXPECT_EQ(solve(factor), first);
  EXPECT_FALSE(factor.compute(worse, 0.0));
  EXPECT_EQ(solve(factor), first);
  Factor copy = factor;
  EXPECT_EQ(solve(copy), first);
}

TEST_P(FactorWithKernels, SolvesWhatTheHessianMultiplies) {
  test_support::FacePatchOptions patch;
  patch.half_columns = 5;
  patch.row_mm = 16.0;
  patch.rows_below_mouth = 2;
  patch.rows_above_mouth = 8;
  const Anatomy anatomy = test_support::make_face_patch(patch);
  for (const Topology topology : {Topology::kPrisms, Topology::kCentroids}) {
    TissueModel model;
    model.lattice.topology = topology;
    const FaceEnergy energy(anatomy, model);
    TissueHessian hessian = energy.make_hessian();
    energy.hessian(energy.lattice().rest_mm, hessian);
    Factor factor(hessian.free(), kernels());
    ASSERT_TRUE(factor.compute(hessian.free(), 0.0));
    const MatrixXd expected = random_matrix(energy.num_unknowns(), 1, 5);
    MatrixXd solution = test_support::times(hessian.free(), expected);
    Eigen::VectorXd rough = solution;
    factor.solve(solution);
    factor.solve_roughly(rough);
    EXPECT_LT((solution - expected).norm(), 1e-9 * expected.norm());
    EXPECT_LT((rough - expected).norm(), 3e-3 * expected.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Simd,
                         FactorWithKernels,
                         testing::ValuesIn(all_dense_kernels()),
                         [](const auto& kernels) { return std::string(kernels.param->name); });

TEST(Factor, NothingActiveIsNothingToSolve) {
  const ColumnMatrix h = make_sheet(3, 3, 5);
  Factor factor(h, std::vector<int>{});
  EXPECT_TRUE(factor.compute(h, 0.0));
  MatrixXd x = MatrixXd::Ones(h.num_unknowns(), 2);
  factor.solve(x);
  EXPECT_EQ(x, MatrixXd::Zero(h.num_unknowns(), 2));
}

}  // namespace
}  // namespace zygoma
