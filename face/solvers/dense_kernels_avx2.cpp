// Kernels for avx2; flags in CMakeLists.txt.
#define Eigen eigen_avx2
#define ZYGOMA_KERNELS kAvx2Kernels
#define ZYGOMA_KERNELS_NAME "avx2"

namespace zygoma {
struct DenseKernels;
extern const DenseKernels ZYGOMA_KERNELS;
}  // namespace zygoma

#include "face/solvers/dense_kernels_impl.inc"
