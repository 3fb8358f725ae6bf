// The hulls of moving bodies, and the materials of their parts. Bodies of one shape share a run of hulls.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/room.h"
#include "bodies/body_properties.h"
#include "bodies/hull.h"

namespace psim {

/// Runs of equal length and content are one run, which several kinds of body use. T has no padding.
template <class T>
class SharedRuns {
 public:
  void describe(class Archive& a);  ///< for saved states, here and in other classes
  bool has(std::uint32_t first, std::uint32_t count) const;
  /// Whether each run has as many users as those whose first number it is.
  bool used_as(const std::vector<std::uint64_t>& users_of_first) const;
  std::size_t size() const { return all_.size(); }
  bool any() const { return all_.size() > 1; }  ///< whether there ever was a run

  const T& operator[](std::uint32_t i) const { return all_[i]; }

  /// Adds a user to a run and returns the number of its first element; the others follow it. Number 0 means none and is
  /// never given out.
  std::uint32_t acquire(const std::vector<T>& parts) {
    const std::size_t key = hash(parts);
    for (auto [at, end] = by_hash_.equal_range(key); at != end; ++at) {
      Run& run = runs_[at->second];
      if (run.count != parts.size() || !std::equal(parts.begin(), parts.end(), all_.begin() + run.first)) continue;
      ++run.users;
      return run.first;
    }
    const auto count = static_cast<std::uint32_t>(parts.size());
    auto index = static_cast<std::uint32_t>(runs_.size());
    // The run that became free last, since it mostly fits: to look from the front is O(free runs).
    const auto gap = std::find_if(free_.rbegin(), free_.rend(), [&](auto k) { return runs_[k].count == count; });
    const bool fresh = gap == free_.rend();
    if (fresh) {
      runs_.reserve(roomier(runs_));
      free_.reserve(runs_.capacity());  // release() needs no memory
      if (all_.size() + count > all_.capacity()) all_.reserve(2 * all_.size() + count);
    } else {
      index = *gap;
    }
    by_hash_.emplace(key, index);  // the last that needs memory
    if (fresh) {
      runs_.push_back({static_cast<std::uint32_t>(all_.size()), count, 0});
      all_.resize(all_.size() + count);
    } else {
      free_.erase(std::next(gap).base());
    }
    runs_[index].users = 1;
    std::copy(parts.begin(), parts.end(), all_.begin() + runs_[index].first);
    ++changes_;
    return runs_[index].first;
  }

  void release(std::uint32_t first) {
    const std::uint32_t index = index_of(first);
    Run& run = runs_[index];
    if (--run.users != 0) return;
    auto entry = by_hash_.find(hash(std::span(all_).subspan(run.first, run.count)));
    while (entry->second != index) ++entry;  // runs with equal hashes stand side by side
    by_hash_.erase(entry);
    free_.push_back(index);
  }

  /// How often a run was added: what was made of a run is out of date if this changed.
  std::uint64_t changes() const { return changes_; }

  /// Gives all memory back if no body has a shape.
  void give_back() {
    if (!by_hash_.empty() || bytes() == 0) return;
    const std::uint64_t changes = changes_;
    *this = SharedRuns();
    changes_ = changes + 1;
  }

  /// Memory in use; the entry that stands for none does not count.
  std::size_t bytes() const {
    if (all_.size() == 1) return 0;
    return all_.capacity() * sizeof(T) + runs_.size() * (sizeof(Run) + 64);
  }

 private:
  struct Run {
    std::uint32_t first = 0, count = 0;
    std::uint32_t users = 0;
  };

  static std::size_t hash(std::span<const T> parts) {
    const std::string_view bytes(reinterpret_cast<const char*>(parts.data()), parts.size() * sizeof(T));
    return std::hash<std::string_view>()(bytes);
  }
  // The run that begins with this number, or the one behind it.
  std::uint32_t index_of(std::uint32_t first) const {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(runs_, first, {}, &Run::first) - runs_.begin());
  }

  std::vector<T> all_{1};
  std::vector<Run> runs_;  // by their first number
  std::vector<std::uint32_t> free_;
  std::uint64_t changes_ = 0;
  // The runs with users. Look-up only: they differ in content, so that no order matters.
  std::unordered_multimap<std::size_t, std::uint32_t> by_hash_;
};

static_assert(sizeof(Hull) == (4 * Hull::kMost + 6) * sizeof(float) && sizeof(PartProperties) == 12 * sizeof(float));

/// The hulls of all moving bodies that are no discs.
using ShapeTable = SharedRuns<Hull>;
/// What parts have, in bodies whose parts differ.
using PartTable = SharedRuns<PartProperties>;

}  // namespace psim
