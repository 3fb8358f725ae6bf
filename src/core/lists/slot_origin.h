// Where bodies lay when contacts were last laid out, however often they were sorted since.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "lists/broad_cells.h"

namespace psim {

class SlotOrigin {
 public:
  explicit SlotOrigin(const BroadCells& cells) : cells_(cells) {}

  /// By slot: the slot that the body had then.
  const std::uint32_t* slots() const { return moved_on() ? chain_.data() : cells_.from(); }
  void copy(std::vector<std::uint32_t>& to) const { to.assign(slots(), slots() + cells_.sorted()); }
  /// Whether bodies were sorted again since contacts were laid out by the lists of the last sort but one.
  bool moved_on() const { return !chain_.empty(); }

  /// Empty `slots` say that bodies lie in the order by which contacts were laid out.
  void set(const std::vector<std::uint32_t>& slots) { chain_ = slots; }
  /// Call when the lists of the last sort are thrown away before contacts were laid out by them.
  void keep() {
    if (!moved_on()) copy(chain_);
  }
  /// Call when contacts were laid out by the lists of the last sort.
  void forget() { chain_.clear(); }
  /// Call when bodies were sorted.
  void follow() {
    if (!moved_on()) return;
    next_.resize(cells_.sorted());
    for (std::size_t i = 0; i < next_.size(); ++i) {
      const std::uint32_t at = cells_.from()[i];
      next_[i] = at < chain_.size() ? chain_[at] : kNoSlot;
    }
    chain_.swap(next_);
  }

 private:
  const BroadCells& cells_;
  std::vector<std::uint32_t> chain_, next_;  // after lists were thrown away: as slots(), and scratch
};

}  // namespace psim
