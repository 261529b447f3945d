#include "face/solvers/lattice_kernels.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <type_traits>

#include "face/prism.h"

namespace zygoma {

extern const LatticeKernels kBaselineLatticeKernels;
#if defined(__x86_64__)
extern const LatticeKernels kAvx2LatticeKernels;
extern const LatticeKernels kAvx512LatticeKernels;
#endif

std::vector<const LatticeKernels*> all_lattice_kernels() {
  std::vector<const LatticeKernels*> all{&kBaselineLatticeKernels};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    all.push_back(&kAvx2LatticeKernels);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw")) {
      all.push_back(&kAvx512LatticeKernels);
    }
  }
#endif
  return all;
}

const LatticeKernels& lattice_kernels() {
  static const LatticeKernels& widest = *all_lattice_kernels().back();
  return widest;
}

namespace {

using Shape = std::array<double, kShapeNumbers>;

// Of a lane without a spring, and of a law without bands.
template <typename Real>
Shape plain_shape(double softening_mm2) {
  // Nodes that coincide must not divide by zero, even without softening.
  constexpr double kLeast = std::is_same_v<Real, float> ? 1e-12 : 1e-20;
  Shape shape{};
  shape[kSoftening] = std::max(softening_mm2, kLeast);
  return shape;
}

template <typename Real>
Shape shape_of(const Spring& spring) {
  const BiphasicLaw& law = spring.law;
  const double inverse_rest = 1.0 / spring.rest_mm;
  Shape shape = plain_shape<Real>(spring.softening_mm2);
  if (law.stiffening > 0.0) {
    assert(law.band_mm > 0.0);
    const double width = 2.0 * law.band_mm;
    shape[kBandScale] = spring.rest_mm / width;
    shape[kBandOffset] = (law.band_mm - law.critical_mm) / width;
    shape[kBandWidth] = width * inverse_rest;
  }
  if (law.slackening > 0.0) {
    assert(law.slack_band_mm > 0.0 && law.slackening <= law.alpha);
    const double width = 2.0 * law.slack_band_mm;
    shape[kSlackShare] = law.slackening / law.alpha * width * inverse_rest;
    shape[kSlackBandScale] = -spring.rest_mm / width;
    shape[kSlackBandWidth] = width * inverse_rest;
  }
  return shape;
}

// Springs made with the same shares of their rest length agree up to rounding.
bool agree(const Spring& spring, const Shape& a, const Shape& b) {
  constexpr double kRounding = 1e-14;
  for (int k = 0; k < kShapeNumbers; ++k) {
    const bool of_stiffening = k >= kBandScale && k <= kBandWidth;
    if (of_stiffening && spring.law.stiffening <= 0.0) continue;  // multiplied by 0 anyway
    if (std::abs(a[k] - b[k]) > kRounding * std::abs(a[k])) return false;
  }
  return true;
}

}  // namespace

template <typename Real>
SpringSet<Real>::SpringSet(const std::vector<Spring>& springs,
                           const std::vector<Vec3>& x,
                           const LatticeKernels& kernels)
    : kernels_(&kernels),
      lanes_(std::is_same_v<Real, float> ? kernels.spring_lanes_float : kernels.spring_lanes) {
  find_slots(springs, x.size());
  fill_shapes(springs);
  fill_numbers(springs, x);
}

// Every spring is given to the end that owns fewer so far. Nodes that own the same number make
// groups, so that few lanes stay empty.
template <typename Real>
void SpringSet<Real>::find_slots(const std::vector<Spring>& springs, std::size_t num_nodes) {
  std::vector<int> owned(num_nodes, 0);
  std::vector<int> nth(springs.size());  // among the springs of its owner
  std::vector<char> owned_by_j(springs.size());
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const auto [i, j] = std::pair(springs[k].i, springs[k].j);
    assert(i != j && std::max(i, j) < static_cast<int>(num_nodes));
    owned_by_j[k] = owned[j] < owned[i];
    nth[k] = owned[owned_by_j[k] ? j : i]++;
  }
  std::vector<int> nodes(num_nodes);
  std::iota(nodes.begin(), nodes.end(), 0);
  std::erase_if(nodes, [&](int v) { return owned[v] == 0; });
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) { return owned[a] > owned[b]; });

  std::vector<int> place(num_nodes);
  for (std::size_t k = 0; k < nodes.size(); ++k) place[nodes[k]] = static_cast<int>(k);
  for (std::size_t k = 0; k < nodes.size(); k += lanes_) {
    group_begin_.push_back(group_begin_.back() + owned[nodes[k]]);
  }
  // Lanes without a spring pull their owner to itself, lanes without an owner the last one.
  const std::size_t num_groups = group_begin_.size() - 1;
  owner_.resize(num_groups * lanes_);
  neighbor_.resize(num_rows() * lanes_);
  for (std::size_t k = 0; k < owner_.size(); ++k) {
    owner_[k] = 8 * nodes[std::min(k, nodes.size() - 1)];
  }
  for (std::size_t group = 0; group < num_groups; ++group) {
    for (int row = group_begin_[group]; row < group_begin_[group + 1]; ++row) {
      std::copy_n(&owner_[group * lanes_], lanes_, &neighbor_[row * lanes_]);
    }
  }
  slots_.resize(springs.size());
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const auto [i, j] = std::pair(springs[k].i, springs[k].j);
    const int at = place[owned_by_j[k] ? j : i];
    slots_[k] = {static_cast<std::size_t>(group_begin_[at / lanes_] + nth[k]), at % lanes_};
    neighbor_[lane_of(k)] = 8 * (owned_by_j[k] ? i : j);
  }
}

template <typename Real>
void SpringSet<Real>::fill_shapes(const std::vector<Spring>& springs) {
  const auto stiffens = std::find_if(
      springs.begin(), springs.end(), [](const Spring& s) { return s.law.stiffening > 0.0; });
  const Shape common = stiffens != springs.end() ? shape_of<Real>(*stiffens)
                       : springs.empty()         ? plain_shape<Real>(1.0)
                                                 : shape_of<Real>(springs.front());
  const bool all_agree = std::all_of(springs.begin(), springs.end(), [&](const Spring& spring) {
    return agree(spring, common, shape_of<Real>(spring));
  });
  const int step = kShapeNumbers * lanes_;
  shape_step_ = all_agree ? 0 : step;
  shape_.resize(all_agree ? step : num_rows() * step);
  const auto put = [&](const Shape& shape, std::size_t row, int lane) {
    for (int k = 0; k < kShapeNumbers; ++k) {
      shape_[row * step + k * lanes_ + lane] = static_cast<Real>(shape[k]);
    }
  };
  const Shape unused = all_agree ? common : plain_shape<Real>(1.0);
  for (std::size_t k = 0; k < shape_.size() / kShapeNumbers; ++k) {
    put(unused, k / lanes_, static_cast<int>(k % lanes_));
  }
  if (all_agree) return;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    put(shape_of<Real>(springs[k]), slots_[k].row, slots_[k].lane);
  }
}

template <typename Real>
void SpringSet<Real>::find_lengths(const LatticeNode<Real>* nodes,
                                   SimdVector<Real>& by_lane) const {
  by_lane.resize(num_rows() * lanes_);
  if constexpr (std::is_same_v<Real, float>) {
    kernels_->lengths_float(rows(), &nodes->x, by_lane.data());
  } else {
    kernels_->lengths(rows(), &nodes->x, by_lane.data());
  }
}

template <typename Real>
void SpringSet<Real>::fill_numbers(const std::vector<Spring>& springs, const std::vector<Vec3>& x) {
  std::vector<LatticeNode<Real>> nodes;
  reset_nodes(x, nodes);
  SimdVector<Real> length;
  find_lengths(nodes.data(), length);
  const int step = kSpringNumbers * lanes_;
  numbers_.assign(num_rows() * step, Real(0));
  for (std::size_t row = 0; row < num_rows(); ++row) {
    std::fill_n(&numbers_[row * step], 2 * lanes_, Real(1));  // lanes without a spring
  }
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const Spring& spring = springs[k];
    assert(spring.rest_mm > 0.0);
    // The spring's own rest length, but as the kernel would have computed it.
    const double known =
        std::sqrt((x[spring.j] - x[spring.i]).squaredNorm() + spring.softening_mm2);
    set_spring(k, spring.law.alpha, spring.rest_mm + (length[lane_of(k)] - known));
    numbers_[slots_[k].row * step + kStiffening * lanes_ + slots_[k].lane] =
        static_cast<Real>(2.0 * spring.law.stiffening * spring.law.band_mm);
  }
}

template <typename Real>
void SpringSet<Real>::set_spring(std::size_t spring, double alpha, double rest_mm) {
  const auto [row, lane] = slots_[spring];
  Real* number = &numbers_[row * kSpringNumbers * lanes_ + lane];
  number[kRest * lanes_] = static_cast<Real>(rest_mm);
  number[kInverseRest * lanes_] = static_cast<Real>(1.0 / rest_mm);
  number[kAlpha * lanes_] = static_cast<Real>(alpha * rest_mm);
}

template <typename Real>
SpringRows<Real> SpringSet<Real>::rows() const {
  return {static_cast<int>(group_begin_.size()) - 1,
          group_begin_.data(),
          owner_.data(),
          neighbor_.data(),
          numbers_.data(),
          shape_.data(),
          shape_step_};
}

template <typename Real>
Real SpringSet<Real>::energy_and_gradient(LatticeNode<Real>* nodes) const {
  if constexpr (std::is_same_v<Real, float>) {
    return kernels_->springs_float(rows(), &nodes->x);
  } else {
    return kernels_->springs(rows(), &nodes->x);
  }
}

template <typename Real>
void SpringSet<Real>::add_gradient(LatticeNode<Real>* nodes) const {
  if constexpr (std::is_same_v<Real, float>) {
    kernels_->spring_gradient_float(rows(), &nodes->x);
  } else {
    kernels_->spring_gradient(rows(), &nodes->x);
  }
}

template class SpringSet<double>;
template class SpringSet<float>;

PrismSet::PrismSet(const std::vector<Prism>& prisms,
                   const std::vector<Vec3>& x,
                   const Barrier& barrier,
                   const LatticeKernels& kernels)
    : kernels_(&kernels), barrier_(barrier) {
  const std::size_t lanes = kernels.prism_lanes;
  const std::size_t num_rows = (prisms.size() + lanes - 1) / lanes;
  node_.assign(num_rows * 6 * lanes, 0);  // a lane without a prism: node 0 six times, bulk 0
  numbers_.assign(num_rows * kPrismNumbers * lanes, 1.0);
  for (std::size_t k = 0; k < num_rows * lanes; ++k) {
    numbers_[(k / lanes * kPrismNumbers + kBulk) * lanes + k % lanes] = 0.0;
  }
  for (std::size_t k = 0; k < prisms.size(); ++k) {
    for (std::size_t c = 0; c < 6; ++c) {
      node_[(k / lanes * 6 + c) * lanes + k % lanes] = 8 * prisms[k].node[c];
    }
  }
  std::vector<LatticeNode<double>> nodes;
  reset_nodes(x, nodes);
  SimdVector<double> volume72(num_rows * lanes);
  kernels.prisms(rows(), &nodes.data()->x, volume72.data());
  for (std::size_t k = 0; k < prisms.size(); ++k) {
    const Prism& prism = prisms[k];
    assert(prism.rest_mm3 > 0.0);
    // The prism's own rest volume, but as the kernel would have computed it.
    const double known = 72.0 * signed_volume(prism, x);
    const double rest = 72.0 * prism.rest_mm3 + (volume72[k] - known);
    double* number = &numbers_[k / lanes * kPrismNumbers * lanes + k % lanes];
    number[kRestVolume * lanes] = rest;
    number[kInverseRestVolume * lanes] = 1.0 / rest;
    number[kBulk * lanes] = prism.bulk_kpa / 72.0;
  }
}

PrismRows PrismSet::rows() const {
  const int in_row = 6 * kernels_->prism_lanes;
  return {static_cast<int>(node_.size()) / in_row,
          node_.data(),
          numbers_.data(),
          barrier_.start,
          barrier_.ratio};
}

double PrismSet::energy_and_gradient(LatticeNode<double>* nodes) const {
  return kernels_->prisms(rows(), &nodes->x, nullptr);
}

}  // namespace zygoma
