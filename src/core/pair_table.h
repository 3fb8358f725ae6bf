// The neighbour lists of one build: strips of bodies, their candidate pairs and pairs with fixed
// shapes. Two tables alternate, so that stored impulses can be carried from the old to the new.
//
// A strip is some whole rows of the grid: a run of slots. Its pairs reach into itself and the first
// row of the next strip, so all even strips, then all odd strips, can be worked on side by side.
// Bodies too large for the grid form one last group, worked on alone. Behind its pairs lie those of renewed bodies
// (renewal.cpp), by owner and partner, that no strip has; the lower slot owns them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "column.h"

namespace psim {

struct Strip {
  std::uint32_t body_begin = 0, body_end = 0;
  std::uint32_t row_begin = 0, row_end = 0;
  std::uint32_t pair_begin = 0, pair_end = 0;    ///< in PairTable::other
  std::uint32_t block_begin = 0, block_end = 0;  ///< contact blocks
  std::uint32_t single_begin = 0, single_end = 0;  ///< blocks of contacts with fixed shapes
  std::uint32_t loaded_begin = 0, single_loaded_begin = 0;  ///< of these, under heavy loads: to the end
  std::uint32_t colours = 0;
  bool loaded = false;  ///< it has contacts under heavy loads
};

/// A body near a fixed shape.
struct SinglePair {
  std::uint32_t body = 0;
  std::uint32_t shape = 0;
  std::uint32_t contact = 0;  ///< 8 block + lane
};

struct PairTable {
  explicit PairTable(MemoryMeter& meter) : first(meter), owner(meter), other(meter), contact(meter) {}

  Column<std::uint32_t> first;    ///< by slot: its first pair; the high bit marks a strip's first body
  Column<std::uint32_t> owner;    ///< by pair: the slot that found it; ascending in a strip
  Column<std::uint32_t> other;    ///< by pair: the partner's slot
  Column<std::uint32_t> contact;  ///< by pair: 8 block + lane
  std::vector<Strip> strips;      ///< the last is the group of large bodies
  std::vector<std::vector<SinglePair>> singles;  ///< by strip, by body
  std::vector<std::vector<std::uint32_t>> found;  ///< by strip: scratch of their search
  std::uint32_t body_count = 0;
  std::uint32_t large_begin = 0;
  std::uint32_t pair_room = 0;  ///< pairs and gaps: past the last strip's pairs
  std::uint32_t renewed_begin = kNoneRenewed;  ///< first pair of renewed bodies, to the end of the last strip's

  static constexpr std::uint32_t kStripStart = 0x80000000u, kNoneRenewed = 0xFFFFFFFFu;

  void swap(PairTable& o) {
    first.swap(o.first);
    owner.swap(o.owner);
    other.swap(o.other);
    contact.swap(o.contact);
    strips.swap(o.strips);
    singles.swap(o.singles);
    found.swap(o.found);
    std::swap(body_count, o.body_count);
    std::swap(large_begin, o.large_begin);
    std::swap(pair_room, o.pair_room);
    std::swap(renewed_begin, o.renewed_begin);
  }

  /// Makes room for so many pairs, gaps counted.
  void spare(std::size_t bodies, std::size_t pairs) {
    first.reserve(bodies + 1);
    owner.reserve(pairs);
    other.reserve(pairs);
    contact.reserve(pairs);
  }

  /// Whether any(k) holds for a strip k whose contacts may have a body of those of `strip`'s: itself, its neighbours (in
  /// a periodic world the grid's first is beside its last), the large bodies'. All are beside those.
  template <class Any>
  bool any_beside(std::size_t strip, const Any& any) const {
    const std::size_t large = strips.size() - 1;
    if (any(strip) || any(large)) return true;
    if (strip != large) return any(strip == 0 ? large - 1 : strip - 1) || any(strip + 1 == large ? 0 : strip + 1);
    for (std::size_t k = 0; k < large; ++k) {
      if (any(k)) return true;
    }
    return false;
  }

  /// The last word on `first`.
  void mark_strips() {
    first[body_count] = kStripStart;
    for (const Strip& s : strips) {
      if (s.body_begin < s.body_end) first[s.body_begin] |= kStripStart;
    }
  }
  std::uint32_t pairs_of_begin(std::uint32_t body) const { return first[body] & ~kStripStart; }
  std::uint32_t pairs_of_end(std::uint32_t body) const {
    const std::uint32_t next = first[std::size_t{body} + 1];
    return (next & kStripStart) != 0 ? std::min(strips[strip_of(body)].pair_end, renewed_begin) : next;
  }
  /// Pair (a, b), whichever owns it; kNoPair: there is none. O(log strips + log renewed pairs).
  static constexpr std::uint32_t kNoPair = 0xFFFFFFFFu;
  std::uint32_t find(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t pair = find_listed(a, b);
    if (pair != kNoPair || renewed_begin == kNoneRenewed) return pair;
    return find_renewed(std::min(a, b), std::max(a, b));
  }
  /// As the last build left them.
  std::uint32_t find_listed(std::uint32_t a, std::uint32_t b) const {
    for (std::uint32_t p = pairs_of_begin(a), end = pairs_of_end(a); p < end; ++p) {
      if (other[p] == b) return p;
    }
    for (std::uint32_t p = pairs_of_begin(b), end = pairs_of_end(b); p < end; ++p) {
      if (other[p] == a) return p;
    }
    return kNoPair;
  }
  std::uint32_t find_renewed(std::uint32_t low, std::uint32_t high) const {
    const std::uint32_t end = strips.back().pair_end;
    std::uint32_t from = renewed_begin, to = end;
    while (from < to) {
      const std::uint32_t middle = from + (to - from) / 2;
      const bool before = owner[middle] != low ? owner[middle] < low : other[middle] < high;
      (before ? from : to) = before ? middle + 1 : middle;
    }
    return from < end && owner[from] == low && other[from] == high ? from : kNoPair;
  }
  /// The strip that owns a body. O(log strips).
  std::size_t strip_of(std::uint32_t body) const {
    std::size_t low = 0, high = strips.size();
    while (high - low > 1) {
      const std::size_t middle = (low + high) / 2;
      // Empty strips share their begin with the next one; the owner is the last that starts here.
      (strips[middle].body_begin <= body ? low : high) = middle;
    }
    return low;
  }
};

}  // namespace psim
