// Random numbers of the scenes: the same bits with every compiler and library. Counter-based: the
// k-th number of a stream depends on the seed and k alone, so bodies may be placed in any order.
// The mixer is splitmix64's (Steele, Lea, Flood 2014). ~1 ns a number.
#pragma once

#include <cstdint>

namespace psim {

inline std::uint64_t splitmix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

class RandomStream {
 public:
  /// Streams of one seed are unrelated: one a quantity (x, y, radius, ...).
  RandomStream(std::uint64_t seed, std::uint64_t stream)
      : key_(splitmix64(splitmix64(seed + kGolden) + (stream + 1) * kGolden)) {}

  std::uint64_t bits(std::uint64_t k) const { return splitmix64(key_ + (k + 1) * kGolden); }

  /// In [0, 1), a multiple of 2^-53.
  double unit(std::uint64_t k) const { return static_cast<double>(bits(k) >> 11) * 0x1p-53; }

  /// In [-1, 1), a multiple of 2^-52.
  double plus_minus_one(std::uint64_t k) const {
    return static_cast<double>(static_cast<std::int64_t>(bits(k)) >> 11) * 0x1p-52;
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15u;
  std::uint64_t key_;
};

/// The seed of a group when the whole scene has a seed. A scene's own seed is 1 and changes nothing.
/// Stays below 2^53, so that it survives every reader of JSON.
inline std::uint64_t mix_seeds(std::uint64_t group, std::uint64_t scene) {
  if (scene == 1) return group;
  return RandomStream(group, 0).bits(scene) >> 11;
}

}  // namespace psim
