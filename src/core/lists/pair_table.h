// The neighbour lists of one build: strips of bodies, their candidate pairs, and their pairs with fixed
// shapes. Two tables alternate, so that stored impulses can be carried from the old one to the new one.
//
// A strip is a run of slots: some whole rows of the grid. Its pairs name bodies of the strip itself and of
// the first row of the next strip. Therefore all even strips can be worked on side by side, then all odd
// strips. Bodies that are too large for the grid form one last group, which is worked on alone. Behind the
// pairs of that group lie the new pairs of renewed bodies (renewal.h), ordered by owner and partner; the
// lower slot owns such a pair.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/column.h"

namespace psim {

/// A run of blocks of contacts, those under heavy loads last.
struct ContactBlocks {
  std::uint32_t begin = 0, loaded = 0, end = 0;
};

struct Strip {
  std::uint32_t body_begin = 0, body_end = 0;
  std::uint32_t row_begin = 0, row_end = 0;
  std::uint32_t pair_begin = 0, pair_end = 0;     ///< in PairTable::other
  ContactBlocks blocks = {}, static_blocks = {};  ///< contacts of two bodies, contacts with fixed shapes
  std::uint32_t colours = 0;
  bool loaded = false;  ///< the strip has contacts under heavy loads
};

/// A body near a fixed shape.
struct StaticPair {
  std::uint32_t body = 0;
  std::uint32_t shape = 0;
  std::uint32_t contact = 0;  ///< 8 block + lane
};

/// The contacts of a body with fixed shapes in the list of its strip: the first one, and past the last one.
template <class List>
auto contacts_of(List& list, std::uint32_t body) {
  return std::pair(std::ranges::lower_bound(list, body, {}, &StaticPair::body),
                   std::ranges::upper_bound(list, body, {}, &StaticPair::body));
}

/// Names a pair whichever way round it is told: the lower slot or id, then the higher one.
inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

struct PairTable {
  explicit PairTable(MemoryMeter& meter) : first(meter), owner(meter), other(meter), contact(meter) {}

  Column<std::uint32_t> first;    ///< by slot: its first pair; the high bit marks the first body of a strip
  Column<std::uint32_t> owner;    ///< by pair: the slot that found it; ascending in a strip
  Column<std::uint32_t> other;    ///< by pair: the partner's slot; has room for a few more, see find_of
  Column<std::uint32_t> contact;  ///< by pair: 8 block + lane
  std::vector<Strip> strips;      ///< the last is the group of large bodies
  std::vector<std::vector<StaticPair>> static_contacts;  ///< by strip, by body
  std::vector<std::vector<std::uint32_t>> near_scratch;  ///< by strip: of the search for fixed shapes
  std::uint32_t body_count = 0;
  std::uint32_t large_begin = 0;
  std::uint32_t pair_room = 0;                 ///< number of pairs with the gaps between strips
  std::uint32_t renewed_begin = kNoneRenewed;  ///< first pair of renewed bodies; the last strip's end ends them

  /// Gaps included. A table that would be longer throws std::bad_alloc: `first` has 31 bits, and a contact that finds no
  /// colour takes eight lanes, of which there are 2^32.
  static constexpr std::uint32_t kMostPairs = 1u << 28;
  static constexpr std::uint32_t kStripStart = 0x80000000u, kNoneRenewed = 0xFFFFFFFFu, kNoPair = 0xFFFFFFFFu;

  /// Makes room for `pairs` pairs, gaps included.
  void spare(std::size_t bodies, std::size_t pairs) {
    first.reserve(bodies + 1);
    keep_if(true, pairs + kernels::kBlock, owner, other, contact);
  }

  /// Whether any(k) holds for a strip k whose contacts may share a body with those of `strip`: the strip itself, its
  /// two neighbours (in a periodic world the first strip is a neighbour of the last), and the group of large bodies,
  /// which is beside every strip.
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

  /// Completes `first`: its end, and the marks of the strips' first bodies.
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
  /// The index of pair (a, b), whichever body owns it, or kNoPair. O(log strips + log renewed pairs).
  std::uint32_t find(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t pair = find_listed(a, b);
    if (pair != kNoPair || renewed_begin == kNoneRenewed) return pair;
    const std::uint64_t key = pair_key(a, b);
    std::uint32_t begin = renewed_begin, end = strips.back().pair_end;
    while (begin < end) {  // to the first pair whose key is not below
      const std::uint32_t middle = begin + (end - begin) / 2;
      (key_of(middle) < key ? begin : end) = key_of(middle) < key ? middle + 1 : middle;
    }
    return begin != strips.back().pair_end && key_of(begin) == key ? begin : kNoPair;
  }
  /// The same among the pairs of the last build.
  std::uint32_t find_listed(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t pair = find_of(a, b);
    return pair != kNoPair ? pair : find_of(b, a);
  }
  /// The pair that `body` owns with `partner`. Four partners are compared at a time, past the end of a list, too: where a
  /// short list has the partner is hard to predict.
  std::uint32_t find_of(std::uint32_t body, std::uint32_t partner) const {
    const std::uint32_t end = pairs_of_end(body);
    for (std::uint32_t p = pairs_of_begin(body); p < end; p += 4) {
      const std::uint32_t* list = other.data() + p;
      const auto at = [&](std::uint32_t k) { return static_cast<std::uint32_t>(list[k] == partner) << k; };
      const std::uint32_t found = (at(0) | at(1) | at(2) | at(3)) & ((1u << std::min(end - p, 4u)) - 1);
      if (found != 0) return p + static_cast<std::uint32_t>(std::countr_zero(found));
    }
    return kNoPair;
  }
  std::uint64_t key_of(std::uint32_t pair) const { return pair_key(owner[pair], other[pair]); }
  /// The strip that owns a body: the last one that begins there, since an empty strip begins where the next one does.
  /// O(log strips).
  std::size_t strip_of(std::uint32_t body) const {
    const auto after = std::ranges::upper_bound(strips, body, {}, &Strip::body_begin);
    return static_cast<std::size_t>(after - strips.begin()) - 1;
  }
};

}  // namespace psim
