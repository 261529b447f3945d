// The dense work of a multifrontal factorisation, compiled once for every width of SIMD and chosen
// when the program starts, so that one portable program uses what the machine has.
//
// A front is a symmetric matrix of `height` rows, of which the first `own` are eliminated and the
// others handed on. They go in panels of up to kPanelWidth columns. With D the block of the panel's
// own rows and T the rows below it, a panel stores
//
//   P = [ M ]   M = D^-1
//       [ N ]   N = -T D^-1
//
// in place of the triangle of a Cholesky factor, and leaves S + N T^T of the rest S of the front:
// the pivot block is positive definite, its inverse costs little at this width, and then everything
// is a product of dense matrices. Solving is
//
//   forward   v_below := v_below + N v_panel        backward   v_panel := P^T v_(panel and below)
//
// A panel of `width` columns is laid out in strips of kStripRows rows, each strip column by column:
// element (i, k) at ((i / kStripRows) width + k) kStripRows + i % kStripRows, rows filled up with
// zeros. Both passes then read memory from end to end. Results depend on the machine's SIMD width
// and on nothing else.
#pragma once

#include <cstddef>
#include <vector>

namespace zygoma {

constexpr int kPanelWidth = 48;  // a multiple of the rows of a tile in every set of kernels
constexpr int kStripRows = 16;
constexpr int kFrontStep = 24;  // likewise a multiple

// Static, so that no set of kernels shares its copy with code for other machines.
static constexpr int round_up(int value, int step) { return (value + step - 1) / step * step; }

// Numbers in the panels of a front.
static constexpr std::size_t panels_size(int own, int height) {
  std::size_t sum = 0;
  for (int c = 0; c < own; c += kPanelWidth) {
    const int width = own - c < kPanelWidth ? own - c : kPanelWidth;
    sum += static_cast<std::size_t>(round_up(height - c, kStripRows)) * width;
  }
  return sum;
}

// A front in memory: column-major; rows and columns filled up so that tiles need no edges.
static constexpr int front_stride(int height) { return round_up(height, kFrontStep); }
static constexpr std::size_t front_size(int height) {
  return static_cast<std::size_t>(front_stride(height)) * round_up(height, 8);
}

struct Run {  // of rows that stay together
  int from = 0;
  int to = 0;
  int count = 0;
};

struct DenseKernels {
  const char* name;           // "baseline", "avx2", "avx512"
  int most_right_hand_sides;  // of one call of forward_many and backward_many
  int right_hand_side_step;   // of which their number is a multiple

  // Eliminates the own rows of a front, of which it reads the lower triangle. Leaves S in the front
  // and writes the panels. `work` holds kPanelWidth * front_stride(height) numbers. False if a
  // pivot is not positive.
  bool (*eliminate)(double* front, int own, int height, double* panels, double* work);

  // to[run.to + i] += from[run.from + i]
  void (*add)(const double* from, double* to, const Run* runs, int num_runs);

  // v has round_up(height, kStripRows) entries, all of them finite.
  void (*forward)(const double* panels, int own, int height, double* v);
  void (*backward)(const double* panels, int own, int height, double* v);
  void (*forward_float)(const float* panels, int own, int height, float* v);
  void (*backward_float)(const float* panels, int own, int height, float* v);

  // The same for `count` right-hand sides, stored row by row.
  void (*forward_many)(const double* panels, int own, int height, int count, double* v);
  void (*backward_many)(const double* panels, int own, int height, int count, double* v);
};

extern const DenseKernels kBaselineKernels;
extern const DenseKernels kAvx2Kernels;  // these two on x86-64 only
extern const DenseKernels kAvx512Kernels;

// The kernels this machine can run, widest first.
std::vector<const DenseKernels*> all_dense_kernels();
const DenseKernels& dense_kernels();  // the first of them

}  // namespace zygoma
