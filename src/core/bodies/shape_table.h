// The hulls of moving bodies. Bodies of one shape share a set of hulls.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bodies/hull.h"

namespace psim {

struct BodyKind;

class ShapeTable {
 public:
  void describe(class Archive& a);  ///< for saved states, here and in other classes
  bool has(const BodyKind& kind) const;
  /// Whether each set has as many users as those whose first hull it is.
  bool used_as(const std::vector<std::uint64_t>& users_of_first) const;
  std::size_t size() const { return hulls_.size(); }

  const Hull& operator[](std::uint32_t i) const { return hulls_[i]; }

  /// Adds a user to a set of hulls and returns the number of the first one; the others follow it. Number 0 means a
  /// plain disc and is never given out.
  std::uint32_t acquire(const std::vector<Hull>& parts) {
    const std::uint64_t key = hash(parts);
    for (auto [at, end] = by_hash_.equal_range(key); at != end; ++at) {
      Set& set = sets_[at->second];
      if (!same(set, parts)) continue;
      ++set.users;
      return set.first;
    }
    Set set{static_cast<std::uint32_t>(hulls_.size()), static_cast<std::uint32_t>(parts.size()), 1};
    auto index = static_cast<std::uint32_t>(sets_.size());
    const auto gap = std::find_if(free_.begin(), free_.end(), [&](auto k) { return sets_[k].count == set.count; });
    if (gap == free_.end()) {
      sets_.push_back(set);
      hulls_.insert(hulls_.end(), parts.begin(), parts.end());
    } else {
      index = *gap;
      free_.erase(gap);
      set.first = sets_[index].first;
      sets_[index] = set;
      std::copy(parts.begin(), parts.end(), hulls_.begin() + set.first);
    }
    by_hash_.emplace(key, index);
    by_first_[set.first] = index;
    return set.first;
  }

  void release(std::uint32_t first) {
    const std::uint32_t index = by_first_.at(first);
    if (--sets_[index].users != 0) return;
    std::erase_if(by_hash_, [index](const auto& entry) { return entry.second == index; });
    by_first_.erase(first);
    free_.push_back(index);
  }

  /// Gives all memory back. No body may have a shape.
  void clear() { *this = ShapeTable(); }
  bool empty() const { return by_first_.empty(); }

  /// Memory in use; the entry that stands for discs does not count.
  std::size_t bytes() const {
    if (hulls_.size() == 1) return 0;
    return hulls_.capacity() * sizeof(Hull) + sets_.size() * (sizeof(Set) + 64);
  }

 private:
  struct Set {
    std::uint32_t first = 0, count = 0;
    std::uint32_t users = 0;
  };

  static std::uint64_t hash(const std::vector<Hull>& parts) {
    std::uint64_t h = parts.size();
    for (const Hull& hull : parts) {
      const auto add = [&h](float value) {
        h = (h ^ std::bit_cast<std::uint32_t>(value)) * 0x9E3779B97F4A7C15u;
        h ^= h >> 29;
      };
      for (int k = 0; k < hull.count; ++k) add(hull.x[k]), add(hull.y[k]);
      add(hull.radius);
    }
    return h;
  }
  bool same(const Set& set, const std::vector<Hull>& parts) const {
    return set.users != 0 && set.count == parts.size() &&
           std::equal(parts.begin(), parts.end(), hulls_.begin() + set.first);
  }

  std::vector<Hull> hulls_{1};
  std::vector<Set> sets_;
  std::vector<std::uint32_t> free_;
  // Look-up only: sets differ in content and in their first part, so that no order matters.
  std::unordered_multimap<std::uint64_t, std::uint32_t> by_hash_;
  std::unordered_map<std::uint32_t, std::uint32_t> by_first_;
};

}  // namespace psim
