// Kernels for AVX-512; flags in CMakeLists.txt.
#if defined(__AVX512F__)
#define ZYGOMA_LANES 8
#define ZYGOMA_KERNELS kAvx512Kernels
#define ZYGOMA_KERNELS_NAME "avx512"
#include "face/solvers/dense_kernels.inc"
#endif
