// Random numbers that are the same everywhere: SplitMix64 (Steele, Lea and Flood 2014). Standard distributions are
// not, since each library has its own.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace psim::laws {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Every factor is as likely as any other: 1 to 10 like 10 to 100.
  double logarithmic(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  int from(int low, int high) { return low + below(high - low + 1); }
  bool chance(double share) { return uniform(0, 1) < share; }
  double sign() { return chance(0.5) ? 1 : -1; }
  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& of) {
    return of[static_cast<std::size_t>(below(static_cast<int>(N)))];
  }

 private:
  std::uint64_t state_;
};

}  // namespace psim::laws
