// Kernels for any machine: two doubles and four floats wide, which the compiler maps to SSE2, NEON
// or plain code.
#define ZYGOMA_KERNELS kBaselineLatticeKernels
#define ZYGOMA_KERNELS_NAME "baseline"

#include <cmath>

namespace zygoma {

struct LatticeKernels;
extern const LatticeKernels ZYGOMA_KERNELS;

namespace {

template <typename RealType, int kNumLanes>
struct Vector {
  using Real = RealType;
  typedef Real V __attribute__((vector_size(kNumLanes * sizeof(Real)), may_alias));
  static constexpr int kLanes = kNumLanes;

  static V load(const Real* p) { return *reinterpret_cast<const V*>(p); }
  static void store(Real* p, V v) { *reinterpret_cast<V*>(p) = v; }
  static V fused(V a, V b, V c) { return a * b + c; }
  static V at_least(V a, Real b) { return a > b ? a : V{} + b; }
  static V at_most(V a, Real b) { return a < b ? a : V{} + b; }

  static void root(V squared, V& length, V& inverse) {
    alignas(V) Real lane[kLanes];
    for (int k = 0; k < kLanes; ++k) lane[k] = std::sqrt(squared[k]);
    length = load(lane);
    inverse = Real(1) / length;
  }

  static void gather(const Real* p, const int* node, V& x, V& y, V& z) {
    x = number(p, node);
    y = number(p + 1, node);
    z = number(p + 2, node);
  }
  static V number(const Real* p, const int* node) {
    if constexpr (kLanes == 2) return V{p[node[0]], p[node[1]]};
    if constexpr (kLanes == 4) return V{p[node[0]], p[node[1]], p[node[2]], p[node[3]]};
  }
  static void scatter(Real* p, const int* node, V x, V y, V z) {
    for (int k = 0; k < kLanes; ++k) {
      p[node[k]] += x[k];
      p[node[k] + 1] += y[k];
      p[node[k] + 2] += z[k];
    }
  }
};

using Double = Vector<double, 2>;
using Float = Vector<float, 4>;

}  // namespace
}  // namespace zygoma

#include "face/solvers/lattice_kernels_impl.inc"
