// The hulls of moving bodies. Bodies of one shape share a set of hulls.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/room.h"
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
    const std::size_t key = hash(parts);
    for (auto [at, end] = by_hash_.equal_range(key); at != end; ++at) {
      Set& set = sets_[at->second];
      if (set.count != parts.size() || !std::equal(parts.begin(), parts.end(), hulls_.begin() + set.first)) continue;
      ++set.users;
      return set.first;
    }
    const auto count = static_cast<std::uint32_t>(parts.size());
    auto index = static_cast<std::uint32_t>(sets_.size());
    // The set that became free last, since it mostly fits: to look from the front is O(free sets).
    const auto gap = std::find_if(free_.rbegin(), free_.rend(), [&](auto k) { return sets_[k].count == count; });
    const bool fresh = gap == free_.rend();
    if (fresh) {
      sets_.reserve(roomier(sets_));
      free_.reserve(sets_.capacity());  // release() needs no memory
      if (hulls_.size() + count > hulls_.capacity()) hulls_.reserve(2 * hulls_.size() + count);
    } else {
      index = *gap;
    }
    by_hash_.emplace(key, index);  // the last that needs memory
    if (fresh) {
      sets_.push_back({static_cast<std::uint32_t>(hulls_.size()), count, 0});
      hulls_.resize(hulls_.size() + count);
    } else {
      free_.erase(std::next(gap).base());
    }
    sets_[index].users = 1;
    std::copy(parts.begin(), parts.end(), hulls_.begin() + sets_[index].first);
    ++changes_;
    return sets_[index].first;
  }

  void release(std::uint32_t first) {
    const std::uint32_t index = index_of(first);
    Set& set = sets_[index];
    if (--set.users != 0) return;
    auto entry = by_hash_.find(hash(std::span(hulls_).subspan(set.first, set.count)));
    while (entry->second != index) ++entry;  // sets with equal hashes stand side by side
    by_hash_.erase(entry);
    free_.push_back(index);
  }

  /// How often a set was added: what was made of the hulls of a set is out of date if this changed.
  std::uint64_t changes() const { return changes_; }

  /// Gives all memory back if no body has a shape.
  void give_back() {
    if (!by_hash_.empty() || bytes() == 0) return;
    const std::uint64_t changes = changes_;
    *this = ShapeTable();
    changes_ = changes + 1;
  }

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

  static std::size_t hash(std::span<const Hull> parts) {
    static_assert(sizeof(Hull) == (4 * Hull::kMost + 4) * sizeof(float), "no padding");
    const std::string_view bytes(reinterpret_cast<const char*>(parts.data()), parts.size() * sizeof(Hull));
    return std::hash<std::string_view>()(bytes);
  }
  // The set that begins with this hull, or the one behind it.
  std::uint32_t index_of(std::uint32_t first) const {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(sets_, first, {}, &Set::first) - sets_.begin());
  }

  std::vector<Hull> hulls_{1};
  std::vector<Set> sets_;  // by their first hull
  std::vector<std::uint32_t> free_;
  std::uint64_t changes_ = 0;
  // The sets with users. Look-up only: they differ in content, so that no order matters.
  std::unordered_multimap<std::size_t, std::uint32_t> by_hash_;
};

}  // namespace psim
