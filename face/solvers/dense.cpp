#include "face/solvers/dense.h"

// Fortran interface of BLAS and LAPACK: the same in every release of every implementation.
extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side,
            const char* uplo,
            const char* transpose,
            const char* diagonal,
            const int* m,
            const int* n,
            const double* alpha,
            const double* a,
            const int* lda,
            double* b,
            const int* ldb);
void dsyrk_(const char* uplo,
            const char* transpose,
            const int* n,
            const int* k,
            const double* alpha,
            const double* a,
            const int* lda,
            const double* beta,
            double* c,
            const int* ldc);
void openblas_set_num_threads(int num_threads);
}

namespace zygoma {
namespace {

int rows_between_columns(const Eigen::Ref<const Eigen::MatrixXd>& m) {
  return static_cast<int>(m.outerStride());
}

void keep_to_one_thread() {
  static const bool done = [] {
    openblas_set_num_threads(1);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

bool dense_cholesky(Eigen::Ref<Eigen::MatrixXd> a) {
  keep_to_one_thread();
  const int n = static_cast<int>(a.rows());
  const int lda = rows_between_columns(a);
  int info = 0;
  dpotrf_("L", &n, a.data(), &lda, &info);
  return info == 0;
}

void dense_solve_right(const Eigen::Ref<const Eigen::MatrixXd>& l, Eigen::Ref<Eigen::MatrixXd> x) {
  const int m = static_cast<int>(x.rows());
  const int n = static_cast<int>(x.cols());
  const int ldl = rows_between_columns(l);
  const int ldx = rows_between_columns(x);
  const double one = 1.0;
  dtrsm_("R", "L", "T", "N", &m, &n, &one, l.data(), &ldl, x.data(), &ldx);
}

void dense_subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& x,
                           Eigen::Ref<Eigen::MatrixXd> c) {
  const int n = static_cast<int>(x.rows());
  const int k = static_cast<int>(x.cols());
  const int ldx = rows_between_columns(x);
  const int ldc = rows_between_columns(c);
  const double minus_one = -1.0;
  const double one = 1.0;
  dsyrk_("L", "N", &n, &k, &minus_one, x.data(), &ldx, &one, c.data(), &ldc);
}

}  // namespace zygoma
