// Positions are integers on a lattice. Its pitch is a power of two, the finest with which the world fits
// into +-2^29 steps (1000 m: 2^-20 m = 0.95 um). A float offset beside each position holds the remainder
// below one step, so nothing is lost and precision is the same everywhere. Differences of positions are
// exact, and a scene that is moved by whole steps gives the same bits. In a periodic world the lattice
// spans exactly 2^32 steps, so wrapping around is integer overflow.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/elementary.h"
#include "base/rotor.h"
#include "psim/types.h"

namespace psim {

/// a - b and a + b modulo 2^32, as two's complement.
inline std::int32_t wrap_sub(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}
inline std::int32_t wrap_add(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

/// A place as the engine holds it: a lattice point and an offset in metres.
struct LatticePoint {
  std::int32_t x = 0, y = 0;
  float dx = 0, dy = 0;
  friend bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

class Lattice {
 public:
  Lattice() = default;
  Lattice(const Bounds& b, bool periodic) {
    if (periodic) {
      pitch_x_ = (b.xmax - b.xmin) * 0x1p-32;
      pitch_y_ = (b.ymax - b.ymin) * 0x1p-32;
      centre_ = {b.xmin + (b.xmax - b.xmin) / 2, b.ymin + (b.ymax - b.ymin) / 2};
      wraps_ = true;
      return;
    }
    int exponent = 0;
    std::frexp(greater(b.xmax - b.xmin, b.ymax - b.ymin) / 2, &exponent);  // half the width <= 2^exponent
    pitch_x_ = pitch_y_ = std::ldexp(1.0, exponent - 29);
    centre_ = {std::nearbyint((b.xmin / 2 + b.xmax / 2) / pitch_x_) * pitch_x_,
               std::nearbyint((b.ymin / 2 + b.ymax / 2) / pitch_y_) * pitch_y_};
  }

  double pitch_x() const { return pitch_x_; }
  double pitch_y() const { return pitch_y_; }

  /// The lattice place of a world position (clamped to the lattice where it does not wrap).
  LatticePoint to_lattice(Vec2 p) const {
    const auto finite = [](double d) { return lesser(greater(d, -0x1p100), 0x1p100); };  // as a float
    return moved({}, {finite(p.x - centre_.x), finite(p.y - centre_.y)});
  }

  /// The lattice place of `place` + `arm`. The arm is added on the lattice, so that a scene that is moved
  /// by whole steps has the same bits.
  LatticePoint to_lattice(Vec2 place, Vec2 arm) const { return moved(to_lattice(place), arm); }

  /// So many lattice steps, m.
  Vec2 metres(std::int32_t x, std::int32_t y) const { return {x * pitch_x_, y * pitch_y_}; }
  /// A place, m from the centre of the lattice.
  Vec2 from_centre(const LatticePoint& p) const { return metres(p.x, p.y) + Vec2{p.dx, p.dy}; }
  Vec2 to_world(const LatticePoint& p) const { return centre_ + from_centre(p); }
  /// The vector from one lattice point to another without their offsets, m. The difference is exact.
  Vec2 steps(const LatticePoint& from, const LatticePoint& to) const {
    return metres(wrap_sub(to.x, from.x), wrap_sub(to.y, from.y));
  }
  /// The vector from one place to another, m.
  Vec2 way(const LatticePoint& from, const LatticePoint& to) const {
    return steps(from, to) + (Vec2{to.dx, to.dy} - Vec2{from.dx, from.dy});
  }

  /// Cuts the line from p to q at the edges of the lattice, so that its ends are not clamped one by one
  /// (Liang & Barsky 1984). A line that lies outside stays as it is, and so does any line where the lattice wraps.
  /// Returns whether the line was cut.
  bool clip(Vec2& p, Vec2& q) const {
    if (wraps_) return false;
    double begin = 0, end = 1;
    const Vec2 way = q - p;
    const auto cut = [&](double from, double along, double half) {
      if (along == 0) return std::fabs(from) <= half;
      const double a = (-half - from) / along, b = (half - from) / along;
      begin = greater(lesser(a, b), begin);
      end = lesser(greater(a, b), end);
      return begin < end;
    };
    constexpr double kReach = 0x1p30 - 0x1p20;  // lattice steps
    const Vec2 from = p - centre_;
    if (!cut(from.x, way.x, kReach * pitch_x_) || !cut(from.y, way.y, kReach * pitch_y_)) return false;
    if (end < 1) q = p + end * way;
    if (begin > 0) p = p + begin * way;
    return end < 1 || begin > 0;
  }

  Vec2 centre() const { return centre_; }
  bool wraps() const { return wraps_; }  ///< periodic world

 private:
  LatticePoint moved(LatticePoint p, Vec2 way) const {
    if (way.x == 0 && way.y == 0) return p;
    move(p.x, p.dx, way.x, pitch_x_);
    move(p.y, p.dy, way.y, pitch_y_);
    return p;
  }
  void move(std::int32_t& k, float& rest, double way, double pitch) const {
    const double all = rest + way, steps = std::nearbyint(all / pitch), to = clamped(k + steps);
    rest = static_cast<float>(all - (wraps_ ? steps : to - k) * pitch);
    k = step_of(to);
  }
  double clamped(double steps) const {
    const double limit = wraps_ ? 0x1p62 : 0x1p30;
    return steps < limit ? (steps > -limit ? steps : -limit) : limit;
  }
  static std::int32_t step_of(double steps) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(steps)));
  }

  double pitch_x_ = 1, pitch_y_ = 1;
  Vec2 centre_;
  bool wraps_ = false;
};

}  // namespace psim
