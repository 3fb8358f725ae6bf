// Renewal of persistent lists, body by body: where a few bodies use up their margin before all others, a new search is
// made for those bodies alone, at their present places (docs/decisions/014-lists-body-by-body.md).
//
// The pairs of a renewed body that no strip has yet are put behind the pairs of the last strip
// (PairTable::renewed_begin). All other strips keep their pairs, colours and impulses, and the old pairs of a renewed
// body stay in its strip. The result depends only on the last build and on the place at which each body was last
// searched for.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/broad_phase.h"
#include "lists/heavy_loads.h"
#include "lists/pair_table.h"

namespace psim {

class ListRenewal {
 public:
  void describe(class Archive& a, std::size_t slots);  ///< for saved states

  ListRenewal(const Surroundings& s, BroadPhase& broad) : s_(s), b_(s.bodies), broad_(broad) {}

  /// At most one body in kShare is renewed; if more need it, all lists are made again. The pairs of renewed bodies
  /// are a single job of every pass.
  static constexpr std::uint32_t kShare = 32;
  /// Frames of its motion that a renewed body has room for. Few bodies are renewed: much room for them costs little.
  static constexpr double kFrames = 2.5;

  /// Finds the bodies whose margin does not last for `time` seconds more, and takes the bodies in `others` (slots,
  /// ascending) with them. False if too many bodies are renewed, those of before included. O(bodies).
  bool find(float time, std::span<const std::uint32_t> others);
  /// Whether they were found, and velocities have not changed since.
  bool known() const { return known_; }
  /// The slots of the bodies that find() found, ascending.
  std::span<const std::uint32_t> bodies() const { return found_; }
  bool any() const { return known_ && !found_.empty(); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(found_.size()); }
  /// Discards what find() found, because velocities may have changed.
  void doubt() { known_ = false; }

  /// Searches around the bodies that find() found, with margins of skin + |v| `margin.time`, and fills pairs() and
  /// near(). False if a pair has one body that is much heavier than the other: then all lists must be made again.
  /// O(found log renewed).
  bool look(const HeavyLoads* loads, const kernels::ReachParams& margin, const PairTable& table);
  bool found(std::uint32_t slot) const { return mark_[slot] == kFound; }
  /// New pairs that no strip has, as pair_key, ascending, and fixed shapes near bodies, by body.
  /// The manifolds take out the pairs that are theirs.
  std::vector<std::uint64_t>& pairs() { return fresh_; }
  std::vector<StaticPair>& near() { return near_; }
  /// Puts the new pairs into `table`. False if they are too many: then all lists must be made again. O(pairs of renewed
  /// bodies).
  bool put(PairTable& table);
  /// Ends a renewal: the found bodies are no longer marked as found.
  void finish() {
    for (const std::uint32_t slot : found_) mark_[slot] = kRenewed;
    found_.clear();
  }
  /// Whether the fixed shapes near some body changed, or their order did.
  bool statics_changed() const { return statics_changed_; }
  std::uint32_t renewed() const { return static_cast<std::uint32_t>(renewed_.size()); }

  /// Makes room for the largest number of renewed bodies out of `bodies`.
  void spare(std::size_t bodies);

  /// Call when all lists were made anew: no body is renewed.
  void forget();
  /// After a saved state came back: bodies as the lists were made by, then, once those are there, what was renewed.
  void turn_back();
  void look_again(const PairTable& table);

  std::size_t bytes() const;

 private:
  struct Renewed {  // the place of a body when all lists were made
    std::uint32_t slot = 0;
    std::int32_t x = 0, y = 0;  // lattice steps
    float reach = 0;            // m
  };
  struct Scratch {  // working memory of a job
    std::vector<std::uint32_t> owner, other;
    std::vector<std::uint64_t> pairs;
  };
  enum Mark : std::uint8_t { kListed = 0, kRenewed = 1, kFound = 2 };

  Renewed place_of(std::uint32_t slot) const {
    const std::size_t i = slot;
    return {slot, b_.built[2 * i], b_.built[2 * i + 1], b_.reach[i]};
  }
  // The place along the longer side of the bodies' box.
  std::uint32_t along_axis(std::uint32_t slot) const {
    return static_cast<std::uint32_t>(b_.built[2 * std::size_t{slot} + (broad_.cells().wide() ? 0 : 1)]);
  }
  void place(const Renewed& at);
  template <class Beyond>
  bool find_beyond(const Beyond& beyond, std::span<const std::uint32_t> others);
  void search(const PairTable& table, std::uint32_t slot, Scratch& s) const;
  void search_all(const PairTable& table);
  void put_pairs(PairTable& table) const;
  void put_statics(PairTable& table);

  const Surroundings s_;
  BodyStore& b_;
  BroadPhase& broad_;
  std::vector<std::uint32_t> found_;          // slots, ascending
  std::vector<Renewed> renewed_;              // by slot, ascending
  std::vector<std::uint32_t> linked_;         // slots that were linked by a renewal, not by the last build
  Column<std::uint8_t> mark_{s_.memory};      // by slot
  std::vector<std::uint64_t> places_;         // of renewed bodies: place along the longer side << 32 | slot, ascending
  std::vector<std::uint64_t> pairs_, fresh_;  // as pair_key, ascending
  std::vector<Renewed> spare_renewed_;        // for merging
  std::vector<std::uint64_t> spare_keys_;     // for merging
  std::vector<Scratch> scratch_;              // by job
  std::vector<StaticPair> near_;              // pairs with fixed shapes of all found bodies
  std::vector<std::uint32_t> statics_;
  float most_ = 0;  // m: largest reach of a renewed body
  bool known_ = false, statics_changed_ = false;
};

}  // namespace psim
