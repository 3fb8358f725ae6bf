// Numbers and choices taken from bytes, front to back; zeros when they have run out. The same bytes
// give the same calls with every compiler, so that a fuzzer's finding is a test's input.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "inputs.h"
#include "psim/types.h"

namespace psim::fuzz {

class ByteSource {
 public:
  explicit ByteSource(Bytes bytes) : bytes_(bytes) {}

  bool empty() const { return at_ == bytes_.size(); }
  std::uint8_t byte() { return at_ < bytes_.size() ? bytes_[at_++] : std::uint8_t{0}; }
  std::size_t below(std::size_t n) { return n < 2 ? 0 : byte() % n; }  // n <= 256
  std::size_t below_wide(std::size_t n) {                              // n <= 65536
    const int bits = byte() << 8 | byte();
    return n < 2 ? 0 : static_cast<std::size_t>(bits) % n;
  }
  bool chance(int of_256) { return byte() < of_256; }

  /// In steps of (high - low) / 65535.
  double uniform(double low, double high) {
    const int bits = byte() << 8 | byte();
    return low + (high - low) * bits / 65535;
  }

  /// Mostly between low and high; unless `tame`, now and then what nobody should say.
  double number(double low, double high) {
    if (tame || !chance(12)) return uniform(low, high);
    constexpr double kInf = std::numeric_limits<double>::infinity();
    constexpr std::array<double, 24> kOdd = {std::numeric_limits<double>::quiet_NaN(),
                                             kInf,
                                             -kInf,
                                             0,
                                             -0.0,
                                             1e-320,
                                             1e-300,
                                             1e-45,
                                             1e-30,
                                             1e-9,
                                             1e-6,
                                             1e6,
                                             1e9,
                                             -1e9,
                                             1e12,
                                             1e15,
                                             1e30,
                                             -1e30,
                                             3e38,
                                             1e39,
                                             1e100,
                                             1e300,
                                             -1e300,
                                             std::numeric_limits<double>::max()};
    return kOdd[below(kOdd.size())];
  }
  Vec2 vec2(double low, double high) {
    const double x = number(low, high);
    return {x, number(low, high)};
  }

  /// A point near the middle of the session: most bodies are placed and asked for there.
  Vec2 place(double low, double high) {
    const Vec2 at = vec2(low, high);
    return {home.x + at.x, home.y + at.y};
  }

  bool tame = true;
  bool rich = false;  ///< large worlds and all calls; without it, the calls of older inputs alone
  Vec2 home;          ///< metres

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

}  // namespace psim::fuzz
