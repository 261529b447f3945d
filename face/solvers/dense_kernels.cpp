#include "face/solvers/dense_kernels.h"

namespace zygoma {

const DenseKernels& dense_kernels() {
#if defined(__x86_64__)
  if (kAvx512Kernels.runs_here()) return kAvx512Kernels;
  if (kAvx2Kernels.runs_here()) return kAvx2Kernels;
#endif
  return kBaselineKernels;
}

}  // namespace zygoma
