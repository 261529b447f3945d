// Kernels for AVX2 with fused multiply-add; flags in CMakeLists.txt.
#if defined(__AVX2__)
#define ZYGOMA_LANES 4
#define ZYGOMA_KERNELS kAvx2Kernels
#define ZYGOMA_KERNELS_NAME "avx2"
#include "face/solvers/dense_kernels.inc"
#endif
