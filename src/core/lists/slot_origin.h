// Where bodies lay when contacts were last laid out, however often they were sorted since.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lists/broad_cells.h"

namespace psim {

class SlotOrigin {
 public:
  explicit SlotOrigin(const BroadCells& cells) : cells_(cells) {}

  /// By slot: the slot that the body had then.
  std::span<const std::uint32_t> slots() const { return moved_on() ? std::span(chain_) : cells_.from(); }
  void copy(std::vector<std::uint32_t>& to) const { to.assign(slots().begin(), slots().end()); }
  /// Whether lists were thrown away after a sort since contacts were laid out.
  bool moved_on() const { return !chain_.empty(); }

  /// Empty `slots` say that bodies lie in the order by which contacts were laid out.
  void set(const std::vector<std::uint32_t>& slots) { chain_ = slots; }
  /// Call when the lists of the last sort are thrown away before contacts were laid out by them.
  void keep() {
    if (!moved_on()) copy(chain_);
  }
  /// Call when contacts were laid out by the lists of the last sort.
  void forget() { chain_.clear(); }
  /// Call before so many bodies are sorted: follow() needs no memory then.
  void make_room(std::size_t bodies) {
    if (moved_on()) next_.reserve(bodies);
  }
  /// Call when bodies were sorted.
  void follow() {
    if (!moved_on()) return;
    next_.assign(cells_.from().begin(), cells_.from().end());
    for (std::uint32_t& slot : next_) slot = slot < chain_.size() ? chain_[slot] : kNoSlot;
    chain_.swap(next_);
  }

 private:
  const BroadCells& cells_;
  std::vector<std::uint32_t> chain_;  // after lists were thrown away: as slots()
  std::vector<std::uint32_t> next_;   // scratch of follow()
};

}  // namespace psim
