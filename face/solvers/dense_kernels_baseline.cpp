// Kernels for any machine.
#define Eigen eigen_baseline
#define ZYGOMA_KERNELS kBaselineKernels
#define ZYGOMA_KERNELS_NAME "baseline"

namespace zygoma {
struct DenseKernels;
extern const DenseKernels ZYGOMA_KERNELS;
}  // namespace zygoma

#include "face/solvers/dense_kernels_impl.inc"
