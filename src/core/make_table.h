// What few bodies have: a shape other than a disc, a filter. Bodies alike in it share an entry.
#pragma once

#include <cstdint>
#include <vector>

#include "psim/desc.h"
#include "rotor.h"

namespace psim {

struct Make {
  std::uint32_t first_hull = 0;      ///< in the ShapeTable; 0: a plain disc
  std::uint32_t hull_count = 0;
  float centre_x = 0, centre_y = 0;  ///< m: centre of mass in the body's frame
  float inner = 0;                   ///< m: least distance from the centre to the surface
  Filter filter;
  bool bullet = false;
  bool sensor = false;
  friend bool operator==(const Make&, const Make&) = default;
};

/// From a body's place to its centre of mass when it is turned by `angle`, m.
inline Vec2 arm_of(const Make& make, double angle) {
  if (make.centre_x == 0 && make.centre_y == 0) return {};
  const SineCosine q = sine_cosine(angle);
  const double x = static_cast<double>(make.centre_x), y = static_cast<double>(make.centre_y);
  return {q.cosine * x - q.sine * y, q.sine * x + q.cosine * y};
}

/// Whether two bodies collide, by their filters.
inline bool meet(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

class MakeTable {
  friend struct Image;

 public:
  /// Entries fit into the 24 bits that Surface has for them.
  static constexpr std::uint32_t kMost = (1u << 24) - 1;

  const Make& operator[](std::uint32_t i) const { return list_[i].make; }

  /// 0 for a plain disc; kMost + 1 if there are too many.
  std::uint32_t acquire(const Make& make) {
    if (make == Make{}) return 0;
    if (last_ != 0 && list_[last_].users != 0 && list_[last_].make == make) {
      ++list_[last_].users;
      return last_;
    }
    for (std::size_t i = 1; i < list_.size() && i < kLooked; ++i) {
      if (list_[i].users == 0 || !(list_[i].make == make)) continue;
      ++list_[i].users;
      return last_ = static_cast<std::uint32_t>(i);
    }
    if (!free_.empty()) {
      last_ = free_.back();
      free_.pop_back();
      list_[last_] = {make, 1};
      return last_;
    }
    if (list_.size() > kMost) return kMost + 1;
    list_.push_back({make, 1});
    return last_ = static_cast<std::uint32_t>(list_.size() - 1);
  }
  void release(std::uint32_t i) {
    if (i != 0 && --list_[i].users == 0) free_.push_back(i);
  }
  std::size_t bytes() const { return list_.capacity() * sizeof(Entry); }

 private:
  static constexpr std::size_t kLooked = 64;  // entries that are searched for an equal one
  struct Entry {
    Make make;
    std::uint32_t users = 1;
  };
  std::vector<Entry> list_{1};
  std::vector<std::uint32_t> free_;
  std::uint32_t last_ = 0;
};

}  // namespace psim
