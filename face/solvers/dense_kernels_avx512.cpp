// Kernels for AVX-512; flags in CMakeLists.txt.
#if defined(__AVX512F__)
#define ZYGOMA_LANES 8
#define ZYGOMA_KERNELS kAvx512Kernels
#define ZYGOMA_KERNELS_NAME "avx512"
#define ZYGOMA_RUNS_HERE                                                      \
  (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && \
   __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
#include "face/solvers/dense_kernels.inc"
#endif
