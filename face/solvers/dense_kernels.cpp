#include "face/solvers/dense_kernels.h"

namespace zygoma {

std::vector<const DenseKernels*> all_dense_kernels() {
  std::vector<const DenseKernels*> all;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
    all.push_back(&kAvx512Kernels);
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    all.push_back(&kAvx2Kernels);
  }
#endif
  all.push_back(&kBaselineKernels);
  return all;
}

const DenseKernels& dense_kernels() {
  static const DenseKernels& widest = *all_dense_kernels().front();
  return widest;
}

}  // namespace zygoma
