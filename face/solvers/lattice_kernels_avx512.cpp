// Kernels for AVX-512 (F, DQ, VL, BW); flags in CMakeLists.txt.
#define ZYGOMA_KERNELS kAvx512LatticeKernels
#define ZYGOMA_KERNELS_NAME "avx512"

#if defined(__x86_64__)
#include <immintrin.h>

namespace zygoma {

struct LatticeKernels;
extern const LatticeKernels ZYGOMA_KERNELS;

namespace {

struct Double {
  using Real = double;
  using V = __m512d;
  static constexpr int kLanes = 8;

  static V load(const double* p) { return _mm512_load_pd(p); }
  static void store(double* p, V v) { _mm512_store_pd(p, v); }
  static V fused(V a, V b, V c) { return _mm512_fmadd_pd(a, b, c); }
  static V at_least(V a, double b) { return _mm512_max_pd(a, _mm512_set1_pd(b)); }
  static V at_most(V a, double b) { return _mm512_min_pd(a, _mm512_set1_pd(b)); }

  // 14 bits, then two steps of Newton: half the time of root and division. Every product that could
  // be contracted with what follows is fused already.
  static void root(V squared, V& length, V& inverse) {
    inverse = _mm512_rsqrt14_pd(squared);
    length = squared * inverse;
    for (int step = 0; step < 2; ++step) {
      const V half = 0.5 * _mm512_fnmadd_pd(length, inverse, _mm512_set1_pd(1.0));
      length = _mm512_fmadd_pd(half, length, length);
      inverse = _mm512_fmadd_pd(half, inverse, inverse);
    }
  }

  // Nodes k and k + 4 share a register, so that lanes come out in order.
  static V pair(const double* x, const int* node, int k) {
    return _mm512_insertf64x4(
        _mm512_castpd256_pd512(_mm256_load_pd(x + node[k])), _mm256_load_pd(x + node[k + 4]), 1);
  }
  static void gather(const double* p, const int* node, V& x, V& y, V& z) {
    const V a = pair(p, node, 0);
    const V b = pair(p, node, 1);
    const V c = pair(p, node, 2);
    const V d = pair(p, node, 3);
    const V xz_ab = _mm512_unpacklo_pd(a, b);  // x a b, z a b, then the same of the other nodes
    const V xz_cd = _mm512_unpacklo_pd(c, d);
    const V y_ab = _mm512_unpackhi_pd(a, b);
    const V y_cd = _mm512_unpackhi_pd(c, d);
    const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    const __m512i high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    x = _mm512_permutex2var_pd(xz_ab, low, xz_cd);
    y = _mm512_permutex2var_pd(y_ab, low, y_cd);
    z = _mm512_permutex2var_pd(xz_ab, high, xz_cd);
  }

  static void add(double* p, __m256d v) { _mm256_store_pd(p, _mm256_add_pd(_mm256_load_pd(p), v)); }
  static void scatter(double* p, const int* node, V x, V y, V z) {
    const V xy_02 = _mm512_unpacklo_pd(x, y);  // nodes 0, 2, 4, 6
    const V xy_13 = _mm512_unpackhi_pd(x, y);
    // The fourth number is not used by anybody: z again.
    const V n04 = _mm512_permutex2var_pd(xy_02, _mm512_setr_epi64(0, 1, 8, 8, 4, 5, 12, 12), z);
    const V n15 = _mm512_permutex2var_pd(xy_13, _mm512_setr_epi64(0, 1, 9, 9, 4, 5, 13, 13), z);
    const V n26 = _mm512_permutex2var_pd(xy_02, _mm512_setr_epi64(2, 3, 10, 10, 6, 7, 14, 14), z);
    const V n37 = _mm512_permutex2var_pd(xy_13, _mm512_setr_epi64(2, 3, 11, 11, 6, 7, 15, 15), z);
    add(p + node[0], _mm512_castpd512_pd256(n04));
    add(p + node[1], _mm512_castpd512_pd256(n15));
    add(p + node[2], _mm512_castpd512_pd256(n26));
    add(p + node[3], _mm512_castpd512_pd256(n37));
    add(p + node[4], _mm512_extractf64x4_pd(n04, 1));
    add(p + node[5], _mm512_extractf64x4_pd(n15, 1));
    add(p + node[6], _mm512_extractf64x4_pd(n26, 1));
    add(p + node[7], _mm512_extractf64x4_pd(n37, 1));
  }
};

struct Float {
  using Real = float;
  using V = __m512;
  static constexpr int kLanes = 16;

  static V load(const float* p) { return _mm512_load_ps(p); }
  static void store(float* p, V v) { _mm512_store_ps(p, v); }
  static V fused(V a, V b, V c) { return _mm512_fmadd_ps(a, b, c); }
  static V at_least(V a, float b) { return _mm512_max_ps(a, _mm512_set1_ps(b)); }
  static V at_most(V a, float b) { return _mm512_min_ps(a, _mm512_set1_ps(b)); }

  // 14 bits, then one step of Newton: 1e-7. Every product that could be contracted with what
  // follows is fused already.
  static void root(V squared, V& length, V& inverse) {
    const V y = _mm512_rsqrt14_ps(squared);
    const V l = squared * y;
    const V off = _mm512_fnmadd_ps(l, y, _mm512_set1_ps(1.0F));
    const V half = 0.5F * off;
    length = _mm512_fmadd_ps(half, l, l);
    inverse = _mm512_fmadd_ps(half, y, y);
  }

  // Nodes k, k + 4, k + 8, k + 12 in one register.
  static V quad(const float* x, const int* node, int k) {
    V v = _mm512_castps128_ps512(_mm_load_ps(x + node[k]));
    v = _mm512_insertf32x4(v, _mm_load_ps(x + node[k + 4]), 1);
    v = _mm512_insertf32x4(v, _mm_load_ps(x + node[k + 8]), 2);
    return _mm512_insertf32x4(v, _mm_load_ps(x + node[k + 12]), 3);
  }
  static V low_pairs(V a, V b) {
    return _mm512_castpd_ps(_mm512_unpacklo_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
  }
  static V high_pairs(V a, V b) {
    return _mm512_castpd_ps(_mm512_unpackhi_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
  }
  static void gather(const float* p, const int* node, V& x, V& y, V& z) {
    const V a = quad(p, node, 0);
    const V b = quad(p, node, 1);
    const V c = quad(p, node, 2);
    const V d = quad(p, node, 3);
    const V xy_ab = _mm512_unpacklo_ps(a, b);
    const V xy_cd = _mm512_unpacklo_ps(c, d);
    x = low_pairs(xy_ab, xy_cd);
    y = high_pairs(xy_ab, xy_cd);
    z = low_pairs(_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
  }

  static void add(float* p, __m128 v) { _mm_store_ps(p, _mm_add_ps(_mm_load_ps(p), v)); }
  static void scatter(float* p, const int* node, V x, V y, V z) {
    const V xy_01 = _mm512_unpacklo_ps(x, y);
    const V xy_23 = _mm512_unpackhi_ps(x, y);
    const V zz_01 = _mm512_unpacklo_ps(z, z);
    const V zz_23 = _mm512_unpackhi_ps(z, z);
    const V n[4] = {low_pairs(xy_01, zz_01),
                    high_pairs(xy_01, zz_01),
                    low_pairs(xy_23, zz_23),
                    high_pairs(xy_23, zz_23)};
    for (int k = 0; k < 4; ++k) add(p + node[k], _mm512_castps512_ps128(n[k]));
    for (int k = 0; k < 4; ++k) add(p + node[4 + k], _mm512_extractf32x4_ps(n[k], 1));
    for (int k = 0; k < 4; ++k) add(p + node[8 + k], _mm512_extractf32x4_ps(n[k], 2));
    for (int k = 0; k < 4; ++k) add(p + node[12 + k], _mm512_extractf32x4_ps(n[k], 3));
  }
};

}  // namespace
}  // namespace zygoma

#include "face/solvers/lattice_kernels_impl.inc"

#endif
