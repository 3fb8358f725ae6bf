// A list of what few bodies have, such as the velocities of the kinematic ones. An entry is found by the id of its body,
// added and removed in O(1), and costs 5 to 11 bytes beside its own: a table with open addressing names the place of each
// id in the list (linear probing; Knuth, The Art of Computer Programming 3, 6.4, algorithms L and R).
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/room.h"
#include "base/sort_keys.h"

namespace psim {

/// `Entry` has a member `id`, which no other entry has.
template <class Entry>
class ListById {
 public:
  auto begin() const { return list_.begin(); }
  auto end() const { return list_.end(); }
  std::size_t size() const { return list_.size(); }
  bool empty() const { return list_.empty(); }
  const Entry& operator[](std::size_t place) const { return list_[place]; }
  std::size_t bytes() const { return bytes_of(list_, table_); }

  /// Makes room for one entry more, which then is added without an allocation.
  void make_room() {
    list_.reserve(roomier(list_));
    if (4 * (list_.size() + 1) > 3 * table_.size()) resize_table(list_.size() + 1);
  }
  void add(const Entry& entry) {
    make_room();
    table_[slot_of(entry.id)] = static_cast<std::uint32_t>(list_.size());
    list_.push_back(entry);
  }
  /// Removes an entry that is there. The last one takes its place.
  void remove(std::uint32_t id) {
    std::size_t gap = slot_of(id);
    const std::uint32_t place = table_[gap];
    table_[slot_of(list_.back().id)] = place;
    list_[place] = list_.back();
    list_.pop_back();
    // Entries that are found through the gap move into it.
    for (std::size_t at = next(gap); table_[at] != kNone; at = next(at)) {
      const std::size_t home = home_of(list_[table_[at]].id);
      if (((at - home) & mask()) >= ((at - gap) & mask())) gap = move_back(at, gap);
    }
    table_[gap] = kNone;
  }
  bool has(std::uint32_t id) const { return !list_.empty() && table_[slot_of(id)] != kNone; }
  /// The entry of a body that has one.
  Entry& at(std::uint32_t id) { return list_[table_[slot_of(id)]]; }
  const Entry& at(std::uint32_t id) const { return list_[table_[slot_of(id)]]; }
  void clear() {
    list_.clear();
    std::ranges::fill(table_, kNone);
  }

  /// For saved states: the entries themselves. After they changed comes index(), which returns whether all ids differ.
  std::vector<Entry>& entries() { return list_; }
  bool index() {
    table_.clear();
    if (!list_.empty()) resize_table(list_.size());
    const auto found = [&](std::size_t place) { return table_[slot_of(list_[place].id)] == place; };
    for (std::size_t place = 0; place < list_.size(); ++place) {
      if (!found(place)) return false;
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  std::size_t mask() const { return table_.size() - 1; }
  std::size_t next(std::size_t slot) const { return (slot + 1) & mask(); }
  std::size_t home_of(std::uint32_t id) const { return mixed(id) & mask(); }
  // Where an id is, or belongs.
  std::size_t slot_of(std::uint32_t id) const {
    std::size_t slot = home_of(id);
    while (table_[slot] != kNone && list_[table_[slot]].id != id) slot = next(slot);
    return slot;
  }
  std::size_t move_back(std::size_t from, std::size_t to) {
    table_[to] = table_[from];
    return from;
  }
  void resize_table(std::size_t entries) {
    std::vector<std::uint32_t> wider(std::bit_ceil(std::max<std::size_t>(entries + entries / 3 + 1, 8)), kNone);
    table_.swap(wider);
    for (std::size_t place = 0; place < list_.size(); ++place) {
      table_[slot_of(list_[place].id)] = static_cast<std::uint32_t>(place);
    }
  }

  std::vector<Entry> list_;
  std::vector<std::uint32_t> table_;  // a power of two, at least a quarter of it kNone; else the place of an entry
};

}  // namespace psim
