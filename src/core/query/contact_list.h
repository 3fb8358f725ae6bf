// World::contacts: who touched at the end of the last step, where, and how hard.
//
// In: the lists, what their contacts carry, what sleepers keep. Out: one Contact a point, ordered by a, then b, then
// normal and point. Nothing runs and no memory is held before the first call; no result of a step depends on it.
// O(contacts); docs/queries-events.md has the times.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "psim/contact.h"
#include "query/observed.h"

namespace psim {

/// The memory of World::contacts and World::strips.
struct ContactList {
  /// A contact before it is written: who touches, and where the contact is found.
  struct Ref {
    enum Kind : std::uint8_t { kPair, kStatic, kManifold, kKept };
    std::uint32_t a = 0, b = 0;  ///< ids, a < b
    std::uint32_t at = 0;        ///< the number of the pair, of the strip's static contact, of the manifold, in `kept`
    std::uint32_t strip = 0;
    Kind kind = kPair;
    std::uint8_t point = 0;  ///< of a manifold
    static constexpr std::uint16_t kNone = 0xFFFF;
    std::uint16_t colour = kNone;
  };

  std::vector<std::uint32_t> now;  ///< by slot of the lists: the present slot; empty if the slots are the same
  std::uint32_t slot(std::uint32_t of_lists) const {
    if (now.empty()) return of_lists;
    return of_lists < now.size() ? now[of_lists] : 0xFFFFFFFFu;
  }
  /// The body in slot i lay in origin[i] when the lists were made. An empty origin: no body has moved.
  void set_moved(const std::vector<std::uint32_t>& origin, std::size_t bodies) {
    constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;
    now.clear();
    if (origin.empty()) return;
    now.assign(std::max(bodies, origin.size()), kNowhere);
    for (std::size_t i = 0; i < origin.size(); ++i) {
      if (origin[i] == kNowhere) continue;
      if (origin[i] >= now.size()) now.resize(std::size_t{origin[i]} + 1, kNowhere);
      now[origin[i]] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<std::vector<Ref>> found;            ///< by strip
  std::vector<std::vector<Contact>> by_sleepers;  ///< what some sleepers each keep; the last: what was kept of late
  std::vector<Contact> kept;                      ///< all of by_sleepers
  std::vector<Ref> refs, sorted;
  std::vector<std::uint32_t> count;  ///< by a
  std::vector<Contact> out;
  std::vector<std::uint32_t> strips;  ///< of World::strips, by id

  std::size_t bytes() const {
    std::size_t n = (refs.capacity() + sorted.capacity()) * sizeof(Ref) +
                    (count.capacity() + now.capacity() + strips.capacity()) * sizeof(count[0]) +
                    (kept.capacity() + out.capacity()) * sizeof(Contact);
    for (const auto& strip : found) n += strip.capacity() * sizeof(Ref);
    for (const auto& some : by_sleepers) n += some.capacity() * sizeof(Contact);
    return n;
  }
};

/// What contacts are told by, beside their lists. While the work for the next step is under way (`begun`), an open
/// contact and one that overlaps without an impulse look alike, and bodies may lie in other slots than the lists say
/// (ContactList::slot).
struct LastStep {
  bool begun = false;           ///< the work for the next step is under way
  bool with_manifolds = false;  ///< some contacts are manifolds
  int substeps = 1;             ///< an impulse of a substep counts as often
  double disc_mass = 1;         ///< kg: impulses of discs are divided by it where all discs have one mass; else 1
};

std::span<const Contact> find_contacts(const Observed& world, const LastStep& last, ContactList& list);

}  // namespace psim
