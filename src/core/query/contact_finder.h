// World::contacts: who touched at the end of the last step, where, and how hard.
//
// In: the lists, what their contacts carry, what sleepers keep. Out: one Contact a point, ordered by a, then b, then
// normal and point. Nothing runs and no memory is held before the first call; no result of a step depends on it.
//
//   find_listed   by strip: the closed contacts of the lists, as references of 20 bytes
//   find_kept     by sleepers: contacts among bodies that lie still, from what they carried when they fell asleep
//   sort          the references by ids
//   write         where the bodies are now: normal, point, separation
//   order         several contacts of one pair, by place
//
// O(contacts); docs/queries-events.md has the times.
#pragma once

#include "base/worker_pool.h"
#include "contacts/contact_store.h"
#include "lists/pair_table.h"
#include "query/contact_list.h"
#include "query/contact_writer.h"

namespace psim {

/// What contacts are read from. While the work for the next step is under way (`begun`), an open contact and one that
/// overlaps without an impulse look alike, and bodies may lie in other slots than the lists say (ContactList::slot).
struct ContactListSource {
  const BodyStore& bodies;
  const StaticShapes& statics;
  const Lattice& lattice;
  const Walls& walls;
  const Sleepers& sleepers;
  const PairTable& table;
  const ContactStore& contacts;
  const Manifolds& manifolds;
  WorkerPool& pool;
  bool begun = false;           ///< the work for the next step is under way
  bool restored = false;        ///< the lists came from a saved state: lanes have impulses but no geometry or colours
  bool with_manifolds = false;  ///< some contacts are manifolds
  bool any_kinematic = false;
  int substeps = 1;        ///< of the last step: an impulse of a substep counts as often
  int usual_substeps = 1;  ///< of the world: the same for what sleepers keep
  double disc_mass = 1;    ///< kg: impulses of discs are divided by it where all discs have one mass; else 1
};

class ContactFinder {
 public:
  ContactFinder(const ContactListSource& source, ContactList& list);

  /// `listed`: the contacts of the lists carry what the last step put there.
  void find(bool listed);
  /// The contacts that were found, in order.
  std::span<const Contact> order();

 private:
  using Ref = ContactList::Ref;
  class StripColours;

  std::uint32_t id_of(std::uint32_t slot) const;
  bool is_dynamic(std::uint32_t id) const;
  bool counts(float impulse) const;
  bool lies_still(std::uint32_t id) const;
  bool is_ground(std::uint32_t shape) const;
  void put(std::size_t strip, std::uint32_t a, std::uint32_t b, Ref::Kind kind, std::size_t at, std::uint16_t colour,
           int point = 0);
  void find_listed();
  void find_pairs(std::size_t strip, const StripColours& colours);
  void find_statics(std::size_t strip, const StripColours& colours);
  void find_manifold(std::size_t strip, const StripColours& colours, std::size_t at);
  bool manifold_closed(std::size_t strip, const ManifoldPair& pair, int point) const;
  void find_kept();
  void keep_of_sleeper(std::size_t k, std::vector<Contact>& out) const;
  void keep_recent(std::vector<Contact>& out) const;
  void sort();
  void write();
  Contact write_pair(const Ref& ref) const;
  Contact write_static(const Ref& ref) const;
  Contact write_manifold(const Ref& ref) const;

  const ContactListSource& source_;
  const BodyStore& bodies_;
  const ContactStore& contacts_;
  const Manifolds& manifolds_;
  const PairTable& table_;
  ContactList& list_;
  ContactWriter writer_;
};

}  // namespace psim
