#include "face/solvers/dense_kernels.h"

namespace zygoma {

extern const DenseKernels kBaselineKernels;
extern const DenseKernels kAvx2Kernels;

const DenseKernels& dense_kernels() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return kAvx2Kernels;
#endif
  return kBaselineKernels;
}

}  // namespace zygoma
