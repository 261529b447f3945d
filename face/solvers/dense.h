// The three dense kernels of a multifrontal Cholesky factorisation, done by OpenBLAS, which picks
// the widest SIMD of the machine when the program starts. It is kept to one thread: its results
// would otherwise depend on their number, and the program has its own use for the cores.
#pragma once

#include <Eigen/Core>

namespace zygoma {

// A := L with L L^T = A; reads and writes the lower triangle. False if A is not positive definite.
bool dense_cholesky(Eigen::Ref<Eigen::MatrixXd> a);

// X := X L^-T for the lower triangle L.
void dense_solve_right(const Eigen::Ref<const Eigen::MatrixXd>& l, Eigen::Ref<Eigen::MatrixXd> x);

// C := C - X X^T in the lower triangle of C.
void dense_subtract_square(const Eigen::Ref<const Eigen::MatrixXd>& x,
                           Eigen::Ref<Eigen::MatrixXd> c);

}  // namespace zygoma
