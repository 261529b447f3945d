// The dense kernels of a multifrontal Cholesky factorisation, compiled once for every width of SIMD
// and chosen when the program starts, so that one portable program uses what the machine has.
// Column-major matrices with the distance between columns given; everything in one thread, so
// results depend on the machine's SIMD width and on nothing else.
#pragma once

namespace zygoma {

struct DenseKernels {
  const char* name;  // "baseline", "avx2"

  // A := L with L L^T = A, n x n; reads and writes the lower triangle. False if A is not positive
  // definite.
  bool (*cholesky)(double* a, int n, int stride);

  // X := X L^-T, X is rows x n.
  void (*solve_right)(const double* l, int n, int l_stride, double* x, int rows, int x_stride);

  // C := C - X X^T in the lower triangle of C; X is rows x n.
  void (*subtract_square)(const double* x, int rows, int n, int x_stride, double* c, int c_stride);

  // One step of solving with a panel (L11 of n rows above L21 of `rows` rows):
  // y := L11^-1 y, part := L21 y.
  void (*forward)(const double* panel, int n, int rows, int stride, double* y, double* part);

  // The step back: y := L11^-T (y - L21^T part).
  void (*backward)(const double* panel, int n, int rows, int stride, double* y, const double* part);
};

// The widest kernels this machine can run.
const DenseKernels& dense_kernels();

}  // namespace zygoma
