// The properties that few bodies have: a shape other than a disc, a filter, a mark as bullet or sensor. Bodies with
// the same ones share an entry; a plain disc that collides with all has entry 0.
#pragma once

#include <cstdint>
#include <vector>

#include "base/rotor.h"
#include "psim/desc.h"

namespace psim {

class ShapeTable;

struct BodyKind {
  std::uint32_t first_hull = 0;  ///< number of the first hull in the ShapeTable; 0: a plain disc
  std::uint32_t hull_count = 0;
  float centre_x = 0, centre_y = 0;  ///< m: centre of mass in the body's frame
  float inner = 0;                   ///< m: least distance from the centre to the surface
  Filter filter;
  bool bullet = false;
  bool sensor = false;
  friend bool operator==(const BodyKind&, const BodyKind&) = default;
};

/// The vector from a body's place to its centre of mass, m, when the body is turned by `angle`.
inline Vec2 arm_of(const BodyKind& kind, double angle) {
  if (kind.centre_x == 0 && kind.centre_y == 0) return {};
  const SineCosine q = sine_cosine(angle);
  const double x = static_cast<double>(kind.centre_x), y = static_cast<double>(kind.centre_y);
  return {q.cosine * x - q.sine * y, q.sine * x + q.cosine * y};
}

/// Whether two bodies collide, by their filters.
inline bool meet(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

class BodyKindTable {
 public:
  template <class A>
  void describe(A& a, const ShapeTable& hulls);
  std::size_t size() const { return list_.size(); }
  std::uint32_t users(std::uint32_t i) const { return list_[i].users; }

  /// The number of an entry fits into 24 bits (BodyProperties::kind).
  static constexpr std::uint32_t kMost = (1u << 24) - 1;

  const BodyKind& operator[](std::uint32_t i) const { return list_[i].kind; }

  /// The number of the entry: 0 for a plain disc, kMost + 1 if there are too many.
  std::uint32_t acquire(const BodyKind& kind) {
    if (kind == BodyKind{}) return 0;
    if (last_ != 0 && list_[last_].users != 0 && list_[last_].kind == kind) {
      ++list_[last_].users;
      return last_;
    }
    for (std::size_t i = 1; i < list_.size() && i < kLooked; ++i) {
      if (list_[i].users == 0 || !(list_[i].kind == kind)) continue;
      ++list_[i].users;
      return last_ = static_cast<std::uint32_t>(i);
    }
    if (!free_.empty()) {
      last_ = free_.back();
      free_.pop_back();
      list_[last_] = {kind, 1};
      return last_;
    }
    if (list_.size() > kMost) return kMost + 1;
    list_.push_back({kind, 1});
    return last_ = static_cast<std::uint32_t>(list_.size() - 1);
  }
  void release(std::uint32_t i) {
    if (i != 0 && --list_[i].users == 0) free_.push_back(i);
  }
  std::size_t bytes() const { return list_.capacity() * sizeof(Entry); }

 private:
  static constexpr std::size_t kLooked = 64;  // entries that are searched for an equal one
  struct Entry {
    BodyKind kind;
    std::uint32_t users = 1;
  };
  std::vector<Entry> list_{1};
  std::vector<std::uint32_t> free_;
  std::uint32_t last_ = 0;
};

}  // namespace psim
