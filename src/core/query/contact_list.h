// World::contacts: who touched at the end of the last step, where, and how hard.
//
// In: the lists, what their contacts carry, what sleepers keep. Out: one Contact a point, ordered by a, then b, then
// normal and point. Nothing runs and no memory is held before the first call; no result of a step depends on it.
// O(contacts); docs/queries-events.md has the times.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "psim/contact.h"
#include "query/observed.h"

namespace psim {

/// The memory of World::contacts and World::strips.
struct ContactList {
  std::vector<std::uint32_t> now;  ///< by slot of the lists: the present slot; empty if the slots are the same
  std::uint32_t slot(std::uint32_t of_lists) const {
    if (now.empty()) return of_lists;
    return of_lists < now.size() ? now[of_lists] : kNoSlot;
  }
  /// The body in slot i lay in origin[i] when the lists were made. An empty origin: no body has moved.
  void set_moved(const std::vector<std::uint32_t>& origin) {
    now.assign(origin.size(), kNoSlot);
    for (std::size_t i = 0; i < origin.size(); ++i) {
      if (origin[i] == kNoSlot) continue;
      if (origin[i] >= now.size()) now.resize(std::size_t{origin[i]} + 1, kNoSlot);
      now[origin[i]] = static_cast<std::uint32_t>(i);
    }
  }

  /// A contact that was found, until all are in order.
  struct Ref {
    std::uint32_t a = 0, b = 0;      ///< ids, a < b
    std::uint32_t list = 0, at = 0;  ///< in `found`
  };
  std::vector<std::vector<Contact>> found;  ///< by strip; then by job of sleepers; then those of Sleepers::recent
  std::vector<Ref> refs, sorted;
  std::vector<std::uint32_t> count;  ///< by a
  std::vector<Contact> out;
  std::vector<std::uint32_t> strips;  ///< of World::strips, by id

  std::size_t bytes() const {
    std::size_t sum = bytes_of(now, refs, sorted, count, out, strips);
    for (const std::vector<Contact>& some : found) sum += bytes_of(some);
    return sum;
  }
};

/// find_contacts() takes this from the last step. While the work for the next step is under way (`begun`), an open
/// contact and one that overlaps without an impulse look alike, and bodies may lie in other slots than the lists say
/// (ContactList::slot).
struct LastStep {
  bool begun = false;           ///< the work for the next step is under way
  bool with_manifolds = false;  ///< some contacts are manifolds
  int substeps = 1;             ///< an impulse of a substep counts as often
  double disc_mass = 1;         ///< kg: impulses of discs are divided by it where all discs have one mass; else 1
};

/// `only`: by id; contacts of the lists alone, whose bodies are all marked.
std::span<const Contact> find_contacts(const Observed& world, const LastStep& last, ContactList& list,
                                       const std::vector<std::uint8_t>* only = nullptr);
/// The deepest overlap of these contacts, m, and of all pairs of shapes in the lists, as they stand now; or 0.
double deepest_contact(const Observed& world, const LastStep& last, ContactList& list);

}  // namespace psim
