// Kernels for AVX2 with FMA; flags in CMakeLists.txt.
#define ZYGOMA_KERNELS kAvx2LatticeKernels
#define ZYGOMA_KERNELS_NAME "avx2"

#if defined(__x86_64__)
#include <immintrin.h>

namespace zygoma {

struct LatticeKernels;
extern const LatticeKernels ZYGOMA_KERNELS;

namespace {

struct Double {
  using Real = double;
  using V = __m256d;
  static constexpr int kLanes = 4;

  static V load(const double* p) { return _mm256_load_pd(p); }
  static void store(double* p, V v) { _mm256_store_pd(p, v); }
  static V fused(V a, V b, V c) { return _mm256_fmadd_pd(a, b, c); }
  static V at_least(V a, double b) { return _mm256_max_pd(a, _mm256_set1_pd(b)); }
  static V at_most(V a, double b) { return _mm256_min_pd(a, _mm256_set1_pd(b)); }

  static void root(V squared, V& length, V& inverse) {
    length = _mm256_sqrt_pd(squared);
    inverse = 1.0 / length;
  }

  static void gather(const double* p, const int* node, V& x, V& y, V& z) {
    const V a = load(p + node[0]);
    const V b = load(p + node[1]);
    const V c = load(p + node[2]);
    const V d = load(p + node[3]);
    const V xz_ab = _mm256_unpacklo_pd(a, b);
    const V xz_cd = _mm256_unpacklo_pd(c, d);
    x = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x20);
    y = _mm256_permute2f128_pd(_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d), 0x20);
    z = _mm256_permute2f128_pd(xz_ab, xz_cd, 0x31);
  }

  static void add(double* p, V v) { store(p, load(p) + v); }
  static void scatter(double* p, const int* node, V x, V y, V z) {
    const V zero = _mm256_setzero_pd();
    const V xy_02 = _mm256_unpacklo_pd(x, y);
    const V xy_13 = _mm256_unpackhi_pd(x, y);
    const V zw_02 = _mm256_unpacklo_pd(z, zero);
    const V zw_13 = _mm256_unpackhi_pd(z, zero);
    add(p + node[0], _mm256_permute2f128_pd(xy_02, zw_02, 0x20));
    add(p + node[1], _mm256_permute2f128_pd(xy_13, zw_13, 0x20));
    add(p + node[2], _mm256_permute2f128_pd(xy_02, zw_02, 0x31));
    add(p + node[3], _mm256_permute2f128_pd(xy_13, zw_13, 0x31));
  }
};

struct Float {
  using Real = float;
  using V = __m256;
  static constexpr int kLanes = 8;

  static V load(const float* p) { return _mm256_load_ps(p); }
  static void store(float* p, V v) { _mm256_store_ps(p, v); }
  static V fused(V a, V b, V c) { return _mm256_fmadd_ps(a, b, c); }
  static V at_least(V a, float b) { return _mm256_max_ps(a, _mm256_set1_ps(b)); }
  static V at_most(V a, float b) { return _mm256_min_ps(a, _mm256_set1_ps(b)); }

  // 11.5 bits, then one step of Newton: 2e-7. Every product that could be contracted with what
  // follows is fused already.
  static void root(V squared, V& length, V& inverse) {
    const V y = _mm256_rsqrt_ps(squared);
    const V l = squared * y;
    const V off = _mm256_fnmadd_ps(l, y, _mm256_set1_ps(1.0F));
    const V half = 0.5F * off;
    length = _mm256_fmadd_ps(half, l, l);
    inverse = _mm256_fmadd_ps(half, y, y);
  }

  // Nodes k and k + 4 in one register.
  static V pair(const float* x, const int* node, int k) {
    return _mm256_insertf128_ps(
        _mm256_castps128_ps256(_mm_load_ps(x + node[k])), _mm_load_ps(x + node[k + 4]), 1);
  }
  static V low_pairs(V a, V b) {
    return _mm256_castpd_ps(_mm256_unpacklo_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
  }
  static V high_pairs(V a, V b) {
    return _mm256_castpd_ps(_mm256_unpackhi_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
  }
  static void gather(const float* p, const int* node, V& x, V& y, V& z) {
    const V a = pair(p, node, 0);
    const V b = pair(p, node, 1);
    const V c = pair(p, node, 2);
    const V d = pair(p, node, 3);
    const V xy_ab = _mm256_unpacklo_ps(a, b);
    const V xy_cd = _mm256_unpacklo_ps(c, d);
    x = low_pairs(xy_ab, xy_cd);
    y = high_pairs(xy_ab, xy_cd);
    z = low_pairs(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
  }

  static void add(float* p, __m128 v) { _mm_store_ps(p, _mm_add_ps(_mm_load_ps(p), v)); }
  static void scatter(float* p, const int* node, V x, V y, V z) {
    const V zero = _mm256_setzero_ps();
    const V xy_01 = _mm256_unpacklo_ps(x, y);
    const V xy_23 = _mm256_unpackhi_ps(x, y);
    const V zw_01 = _mm256_unpacklo_ps(z, zero);
    const V zw_23 = _mm256_unpackhi_ps(z, zero);
    const V n[4] = {low_pairs(xy_01, zw_01),
                    high_pairs(xy_01, zw_01),
                    low_pairs(xy_23, zw_23),
                    high_pairs(xy_23, zw_23)};
    for (int k = 0; k < 4; ++k) add(p + node[k], _mm256_castps256_ps128(n[k]));
    for (int k = 0; k < 4; ++k) add(p + node[4 + k], _mm256_extractf128_ps(n[k], 1));
  }
};

}  // namespace
}  // namespace zygoma

#include "face/solvers/lattice_kernels_impl.inc"

#endif
