// The memory of World::contacts: none before the first call.
#pragma once

#include <cstdint>
#include <vector>

#include "psim/contact.h"

namespace psim {

struct ContactList {
  /// A contact before it is written: who, and where it is found.
  struct Ref {
    enum Kind : std::uint8_t { kPair, kSingle, kManifold, kKept };
    std::uint32_t a = 0, b = 0;  ///< ids, a < b
    std::uint32_t at = 0;        ///< pair, single of its strip, manifold; of kept ones their number
    std::uint32_t strip = 0;
    Kind kind = kPair;
    std::uint8_t point = 0;  ///< of a manifold
    static constexpr std::uint16_t kNone = 0xFFFF;
    std::uint16_t colour = kNone;
  };
  bool begun = false;              ///< work for the next step is under way
  std::vector<std::uint32_t> now;  ///< by slot of the lists: the present one; empty: the same
  std::uint32_t slot(std::uint32_t of_lists) const {
    if (now.empty()) return of_lists;
    return of_lists < now.size() ? now[of_lists] : 0xFFFFFFFFu;
  }
  std::vector<std::vector<Ref>> found;     ///< by strip
  std::vector<std::vector<Contact>> beds;  ///< by some sleepers: what they keep
  std::vector<Contact> kept;
  std::vector<Ref> refs, sorted;
  std::vector<std::uint32_t> count;  ///< by a
  std::vector<Contact> out;
  std::vector<std::uint32_t> strips;  ///< of World::strips, by id

  std::size_t bytes() const {
    std::size_t n = (refs.capacity() + sorted.capacity()) * sizeof(Ref) +
                    (count.capacity() + now.capacity() + strips.capacity()) * sizeof(count[0]) +
                    (kept.capacity() + out.capacity()) * sizeof(Contact);
    for (const auto& strip : found) n += strip.capacity() * sizeof(Ref);
    for (const auto& bed : beds) n += bed.capacity() * sizeof(Contact);
    return n;
  }
};

}  // namespace psim
