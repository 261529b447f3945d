// The kernels of the lattice and the explicit step that is made of them, for every width of SIMD
// this machine has, against two limits measured in the same run:
//
//   arithmetic  operations of the law (54 per spring, a fused multiply-add counts two) at the peak
//               of single precision multiply-adds
//   memory      numbers and indices of a spring (20 bytes in float, 36 in double, read once) at the
//               speed at which as much memory is read
//
// Springs of a face-like patch with the full biphasic law, nodes moved at random. All measured
// things alternate; medians of CPU time.
//
//   explicit_bench [RESULT.csv [LABEL]]
#include <cstdlib>
#include <memory>
#include <numeric>
#include <random>
#include <string>

#include "face/prism.h"
#include "face/solvers/explicit_euler.h"
#include "face/solvers/lattice_kernels.h"
#include "tests/bench/bench_tools.h"
#include "tests/support/face_patch.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace zygoma {
namespace {

using bench::format;
using bench::median;
using bench::ms_per_call;

constexpr int kRepeats = 15;
constexpr double kFlopsPerSpring = 54.0;
constexpr double kBytesPerSpring = 20.0;
constexpr int kPeakSteps = 200000;
constexpr int kChains = 10;

volatile float keep_result;

// Independent chains of multiply-adds, all different so that none can be shared; Gflop/s.
#if defined(__x86_64__)
__attribute__((target("avx512f"))) void chains_avx512() {
  const __m512 factor = _mm512_set1_ps(0.999F);
  const __m512 term = _mm512_set1_ps(0.1F);
  __m512 chain[kChains];
  for (int c = 0; c < kChains; ++c) chain[c] = _mm512_set1_ps(static_cast<float>(c));
  for (int k = 0; k < kPeakSteps; ++k) {
#pragma GCC unroll 10
    for (int c = 0; c < kChains; ++c) chain[c] = _mm512_fmadd_ps(chain[c], factor, term);
  }
  for (int c = 1; c < kChains; ++c) chain[0] = _mm512_add_ps(chain[0], chain[c]);
  keep_result = _mm512_cvtss_f32(chain[0]);
}
__attribute__((target("avx2,fma"))) void chains_avx2() {
  const __m256 factor = _mm256_set1_ps(0.999F);
  const __m256 term = _mm256_set1_ps(0.1F);
  __m256 chain[kChains];
  for (int c = 0; c < kChains; ++c) chain[c] = _mm256_set1_ps(static_cast<float>(c));
  for (int k = 0; k < kPeakSteps; ++k) {
#pragma GCC unroll 10
    for (int c = 0; c < kChains; ++c) chain[c] = _mm256_fmadd_ps(chain[c], factor, term);
  }
  for (int c = 1; c < kChains; ++c) chain[0] = _mm256_add_ps(chain[0], chain[c]);
  keep_result = _mm256_cvtss_f32(chain[0]);
}
#endif

double peak_gflops(const std::string& width) {
#if defined(__x86_64__)
  if (width == "avx512") {
    return 2.0 * 16 * kChains * kPeakSteps / (1e6 * ms_per_call(chains_avx512));
  }
  if (width == "avx2") return 2.0 * 8 * kChains * kPeakSteps / (1e6 * ms_per_call(chains_avx2));
#endif
  return 0.0;
}

// Reading so many bytes again and again, with the widest loads there are; Gbyte/s.
#if defined(__x86_64__)
__attribute__((target("avx512f"))) void read_avx512(const float* p, std::size_t n) {
  __m512 sum[8] = {};
  for (std::size_t k = 0; k < n; k += 128) {
#pragma GCC unroll 8
    for (std::size_t c = 0; c < 8; ++c)
      sum[c] = _mm512_add_ps(sum[c], _mm512_load_ps(p + k + 16 * c));
  }
  for (std::size_t c = 1; c < 8; ++c) sum[0] = _mm512_add_ps(sum[0], sum[c]);
  keep_result = _mm512_cvtss_f32(sum[0]);
}
#endif
void read_plain(const float* p, std::size_t n) {
  typedef float Wide __attribute__((vector_size(16)));
  Wide sum[8] = {};
  for (std::size_t k = 0; k < n; k += 32) {
    for (std::size_t c = 0; c < 8; ++c) sum[c] += *reinterpret_cast<const Wide*>(p + k + 4 * c);
  }
  for (std::size_t c = 1; c < 8; ++c) sum[0] += sum[c];
  keep_result = sum[0][0];
}
double read_gbytes(std::size_t bytes) {
  const std::size_t n = bytes / sizeof(float) / 128 * 128;
  static SimdVector<float> memory;
  memory.assign(n, 1.0F);
  const auto read = [&] {
#if defined(__x86_64__)
    if (std::string(lattice_kernels().name) == "avx512") return read_avx512(memory.data(), n);
#endif
    read_plain(memory.data(), n);
  };
  return static_cast<double>(n * sizeof(float)) / (1e6 * ms_per_call(read));
}

struct Patch {
  Lattice lattice;
  std::vector<Vec3> x;
};

Patch make_patch(int half_columns, double row_mm, int rows_below, int rows_above) {
  test_support::FacePatchOptions options;
  options.half_columns = half_columns;
  options.row_mm = row_mm;
  options.rows_below_mouth = rows_below;
  options.rows_above_mouth = rows_above;
  Patch patch{make_lattice(test_support::make_face_patch(options)), {}};
  patch.x = patch.lattice.rest_mm;
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  for (Vec3& p : patch.x) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += noise(engine);
  }
  return patch;
}

// The loops that solvers ran before there were kernels.
double scalar_energy_and_gradient(const Patch& patch, std::vector<Vec3>& gradient) {
  gradient.assign(patch.x.size(), Vec3::Zero());
  double energy = 0.0;
  for (const Spring& spring : patch.lattice.springs) {
    Vec3 g;
    energy += spring_energy(spring, patch.x[spring.j] - patch.x[spring.i], g);
    gradient[spring.i] -= g;
    gradient[spring.j] += g;
  }
  for (const Prism& prism : patch.lattice.prisms) {
    PrismCorners g;
    const double change = prism_volume(corners_of(prism, patch.x), g) / prism.rest_mm3 - 1.0;
    energy += 0.5 * prism.bulk_kpa * prism.rest_mm3 * change * change;
    for (std::size_t c = 0; c < 6; ++c) gradient[prism.node[c]] += prism.bulk_kpa * change * g[c];
  }
  return energy;
}

// Everything measured on one patch with one width.
struct Case {
  const Patch* patch;
  const LatticeKernels* kernels;
  SpringSet<float> in_float;
  SpringSet<double> in_double;
  PrismSet prisms;
  std::vector<LatticeNode<float>> nodes_float;
  std::vector<LatticeNode<double>> nodes;
  std::vector<double> float_ms, double_ms, both_ms, peak, read;

  Case(const Patch& p, const LatticeKernels& k)
      : patch(&p),
        kernels(&k),
        in_float(p.lattice.springs, p.lattice.rest_mm, k),
        in_double(p.lattice.springs, p.lattice.rest_mm, k),
        prisms(p.lattice.prisms, p.lattice.rest_mm, {}, k) {
    reset_nodes(p.x, nodes_float);
    reset_nodes(p.x, nodes);
  }
  void measure() {
    float_ms.push_back(ms_per_call([&] { in_float.add_gradient(nodes_float.data()); }));
    double_ms.push_back(ms_per_call([&] { in_double.energy_and_gradient(nodes.data()); }));
    both_ms.push_back(ms_per_call([&] {
      reset_nodes(patch->x, nodes);
      in_double.energy_and_gradient(nodes.data());
      prisms.energy_and_gradient(nodes.data());
    }));
    peak.push_back(peak_gflops(kernels->name));
    read.push_back(read_gbytes(static_cast<std::size_t>(
        kBytesPerSpring * static_cast<double>(patch->lattice.springs.size()))));
    reset_nodes(patch->x, nodes_float);
  }
};

// The explicit step as a whole: forces, integration, watchdog.
struct StepCase {
  std::unique_ptr<ExplicitEuler> solver;
  double time_s = 0.0;
  int steps = 0;
  std::vector<double> ms;

  explicit StepCase(const Patch& patch) {
    const std::size_t n = patch.x.size();
    ExplicitNodes nodes{
        std::vector<double>(n, 0.5), std::vector<double>(n, 1.0), std::vector<char>(n, 0)};
    for (std::size_t k = patch.lattice.num_free_nodes; k < n; ++k) nodes.fixed[k] = 1;
    solver = std::make_unique<ExplicitEuler>(patch.lattice.springs, patch.lattice.rest_mm, nodes);
    solver->set_velocity(0, Vec3(1.0, 1.0, 1.0));
    time_s = 256.0 * 0.9 * solver->bound_s();
  }
  void measure() {
    const double begin = bench::cpu_ms();
    int done = 0;
    while (bench::cpu_ms() - begin < 10.0) done += solver->advance(time_s).substeps;
    ms.push_back((bench::cpu_ms() - begin) / done);
  }
};

int run(const std::string& csv, const std::string& label) {
  bench::Table table(
      csv,
      "explicit_bench; medians of " + std::to_string(kRepeats) +
          " alternating repeats, CPU time, one thread; " + label,
      "columns,springs,prisms,simd,float_mspring_per_s,peak_gflops,share_of_arithmetic_bound,"
      "read_gbyte_per_s,share_of_memory_bound,double_mspring_per_s,springs_and_prisms_ms,"
      "scalar_ms,explicit_step_ms");
  const Patch patches[] = {
      make_patch(10, 8.0, 5, 17), make_patch(20, 4.0, 10, 34), make_patch(40, 2.0, 20, 68)};
  for (const Patch& patch : patches) {
    std::vector<Case> cases;
    for (const LatticeKernels* kernels : all_lattice_kernels()) cases.emplace_back(patch, *kernels);
    StepCase step(patch);
    std::vector<double> scalar_ms;
    std::vector<Vec3> gradient;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
      for (Case& c : cases) c.measure();
      step.measure();
      scalar_ms.push_back(ms_per_call([&] { scalar_energy_and_gradient(patch, gradient); }));
    }
    const auto springs = static_cast<double>(patch.lattice.springs.size());
    for (const Case& c : cases) {
      const double rate = springs / median(c.float_ms) * 1e-3;  // millions per second
      const double peak = median(c.peak);
      const double read = median(c.read);
      table.line(
          format("%d,%zu,%zu,%s,%.0f,%.0f,%.3f,%.0f,%.3f,%.0f,%.4f,%.4f,%s",
                 patch.lattice.num_vertices,
                 patch.lattice.springs.size(),
                 patch.lattice.prisms.size(),
                 c.kernels->name,
                 rate,
                 peak,
                 peak > 0.0 ? rate * kFlopsPerSpring * 1e-3 / peak : 0.0,
                 read,
                 rate * kBytesPerSpring * 1e-3 / read,
                 springs / median(c.double_ms) * 1e-3,
                 median(c.both_ms),
                 median(scalar_ms),
                 c.kernels == &lattice_kernels() ? format("%.4f", median(step.ms)).c_str() : ""));
    }
  }
  return 0;
}

}  // namespace
}  // namespace zygoma

int main(int argc, char** argv) {
  return zygoma::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : "");
}
