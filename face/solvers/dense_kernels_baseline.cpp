// Kernels for any machine.
#define ZYGOMA_LANES 2
#define ZYGOMA_KERNELS kBaselineKernels
#define ZYGOMA_KERNELS_NAME "baseline"
#include "face/solvers/dense_kernels.inc"
