// Chance that is the same on every machine: a stream of numbers and a field over the plane, both of
// a seed alone.
#pragma once

#include <cmath>
#include <cstdint>

namespace zygoma {

// SplitMix64.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ULL + 0x1234567ULL) {}
  double operator()() {  // [0, 1)
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) / 9007199254740992.0;
  }
  double between(double low, double high) { return low + (high - low) * (*this)(); }

 private:
  std::uint64_t state_;
};

inline double noise_at(int i, int j, std::uint32_t seed) {  // [-1, 1]
  std::uint32_t h = static_cast<std::uint32_t>(i) * 0x8da6b343U ^
                    static_cast<std::uint32_t>(j) * 0xd8163841U ^ seed * 0xcb1ab31fU;
  h ^= h >> 15U;
  h *= 0x2c1b3c6dU;
  h ^= h >> 12U;
  h *= 0x297a2d39U;
  h ^= h >> 15U;
  return static_cast<double>(h) / 2147483648.0 - 1.0;
}

// Value noise of unit wavelength, [-1, 1].
inline double noise(double x, double y, std::uint32_t seed) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const int i = static_cast<int>(fx);
  const int j = static_cast<int>(fy);
  const double p = x - fx;
  const double q = y - fy;
  const double u = p * p * (3.0 - 2.0 * p);
  const double v = q * q * (3.0 - 2.0 * q);
  const double low = noise_at(i, j, seed) * (1 - u) + noise_at(i + 1, j, seed) * u;
  const double high = noise_at(i, j + 1, seed) * (1 - u) + noise_at(i + 1, j + 1, seed) * u;
  return low * (1 - v) + high * v;
}

}  // namespace zygoma
