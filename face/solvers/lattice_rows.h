// Springs and prisms as the kernels of the lattice read them; raw pointers, since this is the
// border between files compiled for different widths of SIMD.
//
// One *row* is as many springs as a register has lanes, one *group* the rows of as many nodes: lane
// k of every row in a group belongs to the group's k-th node, the *owner*. A spring is evaluated
// once. Its force on the owner stays in a register until the group ends, its force on the other
// end, the *neighbor*, is added in memory lane after lane, so that no two lanes can collide. Lanes
// without a spring have stiffness 0 and their owner as neighbor.
//
// A node is 8 numbers: position x, y, z, unused, then its gradient likewise. Rows give it as 8 *
// index.
#pragma once

namespace zygoma {

// Numbers of one spring, in the order of a row: kSpringNumbers vectors.
enum SpringNumber {
  kRest,         // L0, the length at which the force vanishes
  kInverseRest,  // 1 / L0
  kAlpha,        // alpha L0
  kStiffening,   // (beta - alpha) L0 w
  kSpringNumbers
};

// The shape of the law over the strain s = (l - L0) / L0: bands have the width w = 2 d / L0, and a
// coordinate t = scale s + offset that runs from 0 to 1 along them.
enum ShapeNumber {
  kSoftening,       // eps^2
  kBandScale,       // 1 / w
  kBandOffset,      // (d - e_c) / 2 d
  kBandWidth,       // w
  kSlackShare,      // (alpha - alpha_c) / alpha, times w
  kSlackBandScale,  // -1 / w
  kSlackBandWidth,  // w
  kShapeNumbers
};

template <typename Real>
struct SpringRows {
  int num_groups = 0;
  const int* group_begin = nullptr;  // num_groups + 1 row numbers
  const int* owner = nullptr;        // lanes per group
  const int* neighbor = nullptr;     // lanes per row
  const Real* numbers = nullptr;     // kSpringNumbers x lanes per row
  const Real* shape = nullptr;       // kShapeNumbers x lanes, for all rows or per row
  int shape_step = 0;                // from row to row; 0 = all springs have the same shape
};

// Numbers of one prism, in the order of a row. Volumes are times 72, as they come out of the sums.
enum PrismNumber {
  kRestVolume,         // 72 V0
  kInverseRestVolume,  // 1 / (72 V0)
  kBulk,               // K / 72
  kPrismNumbers
};

struct PrismRows {
  int num_rows = 0;
  const int* node = nullptr;        // 6 x lanes per row
  const double* numbers = nullptr;  // kPrismNumbers x lanes per row
  double barrier_start = 0.0;       // J0
  double barrier_ratio = 0.0;       // against the bulk modulus
};

// The kernels, compiled once for every width of SIMD.
struct LatticeKernels {
  const char* name;  // "baseline", "avx2", "avx512"

  // Springs and prisms in a row.
  int spring_lanes;
  int spring_lanes_float;
  int prism_lanes;

  // Energy; adds its gradient.
  double (*springs)(const SpringRows<double>& rows, double* nodes);
  float (*springs_float)(const SpringRows<float>& rows, float* nodes);
  // The same without the energy.
  void (*spring_gradient)(const SpringRows<double>& rows, double* nodes);
  void (*spring_gradient_float)(const SpringRows<float>& rows, float* nodes);
  // Energy; adds its gradient. If not null, `volume72` gets 72 V per lane.
  double (*prisms)(const PrismRows& rows, double* nodes, double* volume72);

  // Lengths of the springs, one per lane, by the very instructions of the kernels above.
  void (*lengths)(const SpringRows<double>& rows, const double* nodes, double* length);
  void (*lengths_float)(const SpringRows<float>& rows, const float* nodes, float* length);
};

}  // namespace zygoma
