// Which parts of two bodies may meet, by boxes around the parts along the axes of the world. In steps that pairs are
// selected for, long shapes and bodies of several parts have boxes as they lie at the start of the step. In lists that
// last, bodies of several parts have them as they lay when the lists were made, and each may turn so far until it must be
// looked for again.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/column.h"
#include "bodies/surroundings.h"

namespace psim {

class PartBoxes {
 public:
  static constexpr std::uint32_t kMost = 8;  ///< parts

  explicit PartBoxes(const Surroundings& s) : s_(s) {}

  /// No body has boxes. Bodies without any are as large as their circles.
  void begin(std::size_t slots) {
    first_.reserve(slots);
    turn_.reserve(slots);
    std::fill_n(first_.data(), slots, kNoSlot);
    std::fill_n(turn_.data(), slots, 0.0f);
    count_ = 0;
  }
  /// A body will have boxes, if it has few parts: one around all of it, then those of its parts.
  void add(std::size_t slot) {
    const std::uint32_t parts = s_.bodies.kind(s_.bodies.id[slot]).hull_count;
    if (parts > kMost) return;
    first_[slot] = count_;
    boxes_.reserve_loosely(count_ += 1 + parts);
  }
  /// Finds the boxes of a body that lies so, and whose rim may turn by `turn`, m.
  void place(std::size_t slot, Rotor q, float turn) {
    if (!has(slot)) return;
    const BodyKind& kind = s_.bodies.kind(s_.bodies.id[slot]);
    Box& all = boxes_[first_[slot]] = kNothing;
    for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
      const Box box = around(s_.bodies.hulls[kind.first_hull + k], q);
      boxes_[first_[slot] + 1 + k] = box;
      all = {std::min(all.xmin, box.xmin), std::min(all.ymin, box.ymin), std::max(all.xmax, box.xmax),
             std::max(all.ymax, box.ymax)};
    }
    turn_[slot] = turn;
  }
  bool has(std::size_t slot) const { return first_[slot] != kNoSlot; }
  /// Gives the memory back.
  void release() { give_back(first_, turn_, boxes_); }
  float turn_of(std::size_t slot) const { return turn_[slot]; }

  /// How two bodies lie.
  struct Pair {
    std::size_t a = 0, b = 0;  ///< slots
    float dx = 0, dy = 0;      ///< m, from A to B
    float within = 0;          ///< m: parts with a larger gap do not meet
  };
  /// Whether two of their parts may meet.
  bool meet(const Pair& pair, std::uint32_t part_a, std::uint32_t part_b) const {
    return meet(pair, most_of(pair), of(pair.a, 1 + part_a), of(pair.b, 1 + part_b));
  }
  /// Calls each(part of A, part of B) for those that may meet, in order, of so many.
  template <class Each>
  void each_meeting(const Pair& pair, std::uint32_t parts_a, std::uint32_t parts_b, const Each& each) const {
    const float most = most_of(pair);
    const Box all_b = of(pair.b, 0);
    if (!meet(pair, most, of(pair.a, 0), all_b)) return;
    for (std::uint32_t a = 0; a < parts_a; ++a) {
      const Box part = of(pair.a, 1 + a);
      if (!meet(pair, most, part, all_b)) continue;
      for (std::uint32_t b = 0; b < parts_b; ++b) {
        if (meet(pair, most, part, of(pair.b, 1 + b))) each(a, b);
      }
    }
  }

  std::size_t bytes() const { return first_.bytes() + turn_.bytes() + boxes_.bytes(); }

 private:
  struct Box {  // m, from the body's centre
    float xmin, ymin, xmax, ymax;
  };

  static constexpr Box kNothing{1e30f, 1e30f, -1e30f, -1e30f};

  // number: 0 for the whole body, then its parts.
  Box of(std::size_t slot, std::uint32_t number) const {
    if (has(slot)) return boxes_[first_[slot] + number];
    const float r = s_.bodies.radius[slot];
    return {-r, -r, r, r};
  }
  // Returns the distance up to which parts may meet, with what is lost to rounding.
  float most_of(const Pair& pair) const {
    return pair.within + 1e-5f * (s_.bodies.radius[pair.a] + s_.bodies.radius[pair.b]);
  }
  static bool meet(const Pair& pair, float most, const Box& a, const Box& b) {
    return std::max(pair.dx + b.xmin - a.xmax, a.xmin - b.xmax - pair.dx) <= most &&
           std::max(pair.dy + b.ymin - a.ymax, a.ymin - b.ymax - pair.dy) <= most;
  }
  static Box around(const Hull& hull, Rotor q) {
    Box box = kNothing;
    for (int k = 0; k < hull.count; ++k) {
      const float x = q.c * hull.x[k] - q.s * hull.y[k], y = q.s * hull.x[k] + q.c * hull.y[k];
      box = {std::min(x, box.xmin), std::min(y, box.ymin), std::max(x, box.xmax), std::max(y, box.ymax)};
    }
    return {box.xmin - hull.radius, box.ymin - hull.radius, box.xmax + hull.radius, box.ymax + hull.radius};
  }

  const Surroundings s_;
  Column<std::uint32_t> first_{s_.memory};  // by slot: its first box, or kNoSlot
  Column<float> turn_{s_.memory};           // m, by slot
  Column<Box> boxes_{s_.memory};
  std::uint32_t count_ = 0;
};

}  // namespace psim
