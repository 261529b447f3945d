// The factorisation of the tissue's Hessian against the libraries one would otherwise use: Eigen's
// simplicial Cholesky (AMD) and CHOLMOD's supernodal one (METIS). All factor the same matrix, the
// Hessian of the generic head at rest. Repeats alternate between the solvers; medians of the time
// of the processor.
//
// CHOLMOD is only as good as its BLAS is told to be, and both are told when the program starts:
//
//   OMP_THREAD_LIMIT=1 OPENBLAS_NUM_THREADS=1 [OPENBLAS_CORETYPE=SKYLAKEX] factor_bench
//   [RESULT.csv]
//
// Debian's CHOLMOD opens four threads per supernode whatever OMP_NUM_THREADS says, and its OpenBLAS
// does not know processors younger than itself and falls back to SSE. Each run adds its rows.
#include <suitesparse/cholmod.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "face/energy.h"
#include "face/generic_head.h"
#include "face/lattice.h"
#include "face/solvers/factor.h"
#include "tests/bench/bench_tools.h"

extern "C" char* openblas_get_corename() __attribute__((weak));

namespace zygoma {
namespace {

using Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

constexpr int kRightHandSides = 20;

class Solver {
 public:
  virtual ~Solver() = default;
  virtual void factor() = 0;
  virtual MatrixXd solve(const MatrixXd& b) = 0;
  virtual double factor_size() const = 0;  // numbers it stores
};

class Ours : public Solver {
 public:
  Ours(const ColumnMatrix& h, const DenseKernels& kernels) : h_(h), factor_(h, kernels) {}
  void factor() override {
    if (!factor_.compute(h_, 0.0)) throw std::runtime_error("not positive definite");
  }
  MatrixXd solve(const MatrixXd& b) override {
    MatrixXd x = b;
    factor_.solve(x);
    return x;
  }
  double factor_size() const override { return static_cast<double>(factor_.size()); }

 protected:
  const ColumnMatrix& h_;
  Factor factor_;
};

class OursRoughly : public Ours {
 public:
  using Ours::Ours;
  MatrixXd solve(const MatrixXd& b) override {
    MatrixXd x = b;
    for (Eigen::Index c = 0; c < x.cols(); ++c) factor_.solve_roughly(x.col(c));
    return x;
  }
};

class EigenSimplicial : public Solver {
 public:
  explicit EigenSimplicial(const Sparse& lower) : lower_(lower) { llt_.analyzePattern(lower_); }
  void factor() override {
    llt_.factorize(lower_);
    if (llt_.info() != Eigen::Success) throw std::runtime_error("Eigen: not positive definite");
  }
  MatrixXd solve(const MatrixXd& b) override { return llt_.solve(b); }
  double factor_size() const override {
    return static_cast<double>(llt_.matrixL().nestedExpression().nonZeros());
  }

 private:
  const Sparse& lower_;
  Eigen::SimplicialLLT<Sparse> llt_;
};

class CholmodSupernodal : public Solver {
 public:
  explicit CholmodSupernodal(const Sparse& lower) {
    cholmod_start(&common_);
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_METIS;
    common_.postorder = 1;
    matrix_.nrow = matrix_.ncol = static_cast<std::size_t>(lower.rows());
    matrix_.nzmax = static_cast<std::size_t>(lower.nonZeros());
    matrix_.p = const_cast<int*>(lower.outerIndexPtr());
    matrix_.i = const_cast<int*>(lower.innerIndexPtr());
    matrix_.x = const_cast<double*>(lower.valuePtr());
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.dtype = CHOLMOD_DOUBLE;
    matrix_.sorted = matrix_.packed = 1;
    factor_ = cholmod_analyze(&matrix_, &common_);
  }
  CholmodSupernodal(const CholmodSupernodal&) = delete;
  CholmodSupernodal& operator=(const CholmodSupernodal&) = delete;
  ~CholmodSupernodal() override {
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  void factor() override {
    cholmod_factorize(&matrix_, factor_, &common_);
    if (common_.status != CHOLMOD_OK) throw std::runtime_error("CHOLMOD: not positive definite");
  }
  MatrixXd solve(const MatrixXd& b) override {
    cholmod_dense right{};
    right.nrow = right.d = static_cast<std::size_t>(b.rows());
    right.ncol = static_cast<std::size_t>(b.cols());
    right.nzmax = static_cast<std::size_t>(b.size());
    right.x = const_cast<double*>(b.data());
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_A, factor_, &right, nullptr, &x_, nullptr, &y_, &e_, &common_);
    return Eigen::Map<const MatrixXd>(static_cast<const double*>(x_->x), b.rows(), b.cols());
  }
  double factor_size() const override { return static_cast<double>(factor_->xsize); }

 private:
  cholmod_common common_{};
  cholmod_sparse matrix_{};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* x_ = nullptr;
  cholmod_dense* y_ = nullptr;
  cholmod_dense* e_ = nullptr;
};

Sparse lower_triangle(const ColumnMatrix& h) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto unknown = [&](int column, int r) { return 3 * h.nodes[column][r / 3] + r % 3; };
  const auto add = [&](int row, int column, double value) {
    entries.emplace_back(std::max(row, column), std::min(row, column), value);
  };
  for (int c = 0; c < h.num_columns(); ++c) {
    for (int j = 0; j < h.rows(c); ++j) {
      for (int i = j; i < h.rows(c); ++i) add(unknown(c, i), unknown(c, j), h.diagonal(c)(i, j));
    }
  }
  for (std::size_t e = 0; e < h.edges.size(); ++e) {
    const auto [first, second] = h.edges[e];
    for (int j = 0; j < h.rows(first); ++j) {
      for (int i = 0; i < h.rows(second); ++i) {
        add(unknown(second, i), unknown(first, j), h.edge(e)(i, j));
      }
    }
  }
  Sparse lower(h.num_unknowns(), h.num_unknowns());
  lower.setFromTriplets(entries.begin(), entries.end());
  lower.makeCompressed();
  return lower;
}

double processor_ms(const std::function<void()>& work) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

using bench::median;

struct Row {
  std::string name;
  std::unique_ptr<Solver> solver;
  std::vector<double> factor_ms, solve_ms, block_ms;
  double residual = 0.0;
};

std::vector<Row> make_solvers(const ColumnMatrix& h, const Sparse& lower) {
  std::vector<Row> rows;
  const auto add = [&](std::string name, std::unique_ptr<Solver> solver) {
    rows.push_back({std::move(name), std::move(solver), {}, {}, {}, 0.0});
  };
  for (const DenseKernels* kernels : all_dense_kernels()) {
    add(std::string("ours ") + kernels->name, std::make_unique<Ours>(h, *kernels));
  }
  add("ours single precision", std::make_unique<OursRoughly>(h, dense_kernels()));
  const char* core = openblas_get_corename != nullptr ? openblas_get_corename() : "other BLAS";
  add(std::string("CHOLMOD METIS ") + core, std::make_unique<CholmodSupernodal>(lower));
  add("Eigen LLT AMD", std::make_unique<EigenSimplicial>(lower));
  return rows;
}

void measure(const Sparse& lower, int repeats, std::vector<Row>& rows) {
  const MatrixXd b = MatrixXd::Random(lower.rows(), kRightHandSides);
  const MatrixXd one = b.col(0);
  MatrixXd x;
  for (int repeat = 0; repeat <= repeats; ++repeat) {
    for (Row& row : rows) {
      const double factor_ms = processor_ms([&] { row.solver->factor(); });
      if (repeat == 0) {  // warms up
        x = row.solver->solve(one);
        row.residual = (lower.selfadjointView<Eigen::Lower>() * x - one).norm() / one.norm();
        continue;
      }
      row.factor_ms.push_back(factor_ms);
      for (int k = 0; k < 3; ++k) {
        row.solve_ms.push_back(processor_ms([&] { x = row.solver->solve(one); }));
        row.block_ms.push_back(processor_ms([&] { x = row.solver->solve(b); }));
      }
    }
  }
}

int run_bench(const char* csv) {
  std::FILE* file = csv != nullptr ? std::fopen(csv, "a") : nullptr;
  const auto print = [&](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
    if (file != nullptr) std::fprintf(file, "%s\n", line.c_str());
  };
  print("surface_vertices,unknowns,solver,factor_ms,solve_ms,solve_20_ms,size_millions,residual");
  for (const auto& [vertices, repeats] : {std::pair{500, 25}, {2000, 9}, {4000, 5}}) {
    HeadOptions options;
    options.num_surface_vertices = vertices;
    const Anatomy anatomy = make_generic_head({}, options);
    const FaceEnergy energy(anatomy);
    TissueHessian hessian = energy.make_hessian();
    energy.hessian(energy.lattice().rest_mm, hessian);
    const ColumnMatrix& h = hessian.free();
    const Sparse lower = lower_triangle(h);
    std::vector<Row> rows = make_solvers(h, lower);
    measure(lower, repeats, rows);
    for (const Row& row : rows) {
      char line[200];
      std::snprintf(line,
                    sizeof line,
                    "%d,%d,%s,%.2f,%.3f,%.2f,%.2f,%.1e",
                    vertices,
                    h.num_unknowns(),
                    row.name.c_str(),
                    median(row.factor_ms),
                    median(row.solve_ms),
                    median(row.block_ms),
                    1e-6 * row.solver->factor_size(),
                    row.residual);
      print(line);
    }
  }
  if (file != nullptr) std::fclose(file);
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  try {
    return zygoma::run_bench(argc > 1 ? argv[1] : nullptr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "factor_bench: %s\n", error.what());
    return 1;
  }
}
