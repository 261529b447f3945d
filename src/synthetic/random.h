// Random numbers whose bits do not depend on the standard library: splitmix64, one stream per
// purpose, so that a new draw in one place does not shift the others.
#pragma once

#include <cstdint>

namespace zygoma {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t purpose)
      : state_(seed * 0x9E3779B97F4A7C15ULL + purpose * 0xD1B54A32D192ED03ULL) {
    next();
  }

  std::uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1.0p-53);
  }

  // Mean 0, standard deviation 1, within +-4.9: the sum of eight bytes.
  float normal() {
    std::uint64_t bytes = next();
    int sum = 0;
    for (int i = 0; i < 8; ++i, bytes >>= 8) sum += static_cast<int>(bytes & 255U);
    constexpr float kMean = 8.0F * 127.5F;
    constexpr float kInverseSigma = 1.0F / 209.01914F;  // sqrt(8 (256^2 - 1) / 12)
    return (static_cast<float>(sum) - kMean) * kInverseSigma;
  }

 private:
  std::uint64_t state_;
};

}  // namespace zygoma
