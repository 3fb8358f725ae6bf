// The contacts of discs as the solver wants them: blocks of 8 lanes, by strip, then by colour, so that the lanes
// of a block share no body.
//
// Lanes and colours last as long as the PairTable, and impulses stay in their lanes meanwhile. When the lists are
// made anew, the impulses are carried over pair by pair.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "bodies/surroundings.h"
#include "contacts/contact_lanes.h"
#include "contacts/edge_contact.h"
#include "contacts/solver_bodies.h"
#include "contacts/touch_memory.h"
#include "lists/heavy_loads.h"
#include "lists/pair_table.h"
#include "psim/desc.h"

namespace psim {

/// A pair of a table, by its slots, and what its contact carries.
struct PairImpulse {
  std::uint32_t owner = 0, other = 0;
  float impulse = 0, friction = 0;
};

class ContactStore {
 public:
  /// For saved states. Their impulses are saved by pair (state/saved_contacts.h).
  auto fields() {
    return std::tie(model_.model, model_.bounce, pairs.blocks, fixed.blocks, colours_, pairs.count, fixed.count,
                    loaded_blocks_, builds_);
  }
  const ContactModel& model() const { return model_; }

  ContactStore(const Surroundings& s, const Material& wall, SolverBodies& solved, const HeavyLoads& loads)
      : pairs(s.memory), fixed(s.memory), s_(s), wall_(wall), solved_(solved), loads_(loads) {}

  /// A layout in parts, since a step may be spread over frames: begin(), then colour() and lay_out(), each for strips
  /// [begin, end) from the first strip to the last; accept() ends it. Impulses are carried over from the `old` table;
  /// `from` maps new slots to old ones (null: they are the same). `alike` are the properties of all moving bodies, if
  /// they agree. Contacts of bodies in `loads` come last in their strip. `recent` has the impulses of contacts whose
  /// sides fell asleep or woke. O(pairs).
  void begin(ContactModel model, const BodyProperties* alike, PairTable& table);
  void colour(PairTable& table, std::size_t begin, std::size_t end);
  void lay_out(PairTable& table, const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
               std::size_t begin, std::size_t end);
  /// The last strip gets other pairs when bodies are renewed (renewal.h): first lift() takes the impulses of its pairs,
  /// then renew() colours the new ones and lays them out with these impulses. With `static_contacts`, contacts with
  /// fixed shapes are laid out, too; StaticPair::contact is the lane that each had. All other contacts stay. O(pairs of
  /// the strip + strips + static contacts).
  void lift(const PairTable& table);
  PairImpulse impulse_of(const PairTable& table, std::uint32_t pair) const {
    const std::uint32_t at = table.contact[pair];
    return {table.owner[pair], table.other[pair], pairs.impulse[at], model_.rough() ? pairs.friction[at] : 0.0f};
  }
  void renew(bool static_contacts, PairTable& table);
  /// Swaps the impulses of the old table and of the new one, as far as it is laid out. Both exist until accept() or
  /// give_up().
  void turn_back() {
    if (!laying_) return;
    pairs.swap_impulses();
    fixed.swap_impulses();
  }
  void accept() {  ///< the new impulses count from now on
    if (laying_) ++builds_;
    laying_ = false;
  }
  void give_up() { laying_ = false; }  ///< the impulses that are in place count

  /// The narrow phase of discs, at the start of a step: fills nx and ny and gap of every lane, and base and refresh of
  /// static contacts, from lattice positions. `refresh` is the sideways motion, m, after which a normal is computed anew
  /// within the step. A kernel computes pairs of discs; contacts with walls, segments and fixed discs are computed one
  /// by one. O(candidates).
  /// `dt` is the length of the step, s; 0: nothing is going to move.
  void find_gaps(const Walls& walls, float refresh, double dt, const PairTable& table);
  /// Looks again at the edges that discs come to or leave, before the contacts of a substep of length `h`, s, are solved.
  /// O(edges of which another one may take over in the step).
  void follow_edges(const kernels::BodyView& bodies, double h);

  /// Makes room for so many contacts, which are laid out later, of so many bodies whose properties differ.
  void spare(std::size_t bodies, std::size_t pair_lanes, std::size_t static_lanes) {
    entry_.reserve(kernels::round_up_block(bodies));
    colour_.reserve(pair_lanes);
    make_room(pair_lanes, static_lanes);
  }

  /// Blocks that a pass of the solver goes through.
  std::uint64_t pass_blocks() const { return pairs.blocks + fixed.blocks; }
  /// Blocks that the additional sweeps of a pass go through, summed over the sweeps.
  std::uint64_t loaded_blocks() const { return loaded_blocks_; }
  std::uint32_t colours() const { return colours_; }
  /// The colour of a pair of the table that was laid out last. ContactClass::kColours or more: it is solved by itself.
  std::uint32_t colour_of_pair(std::uint32_t pair) const { return colour_[pair]; }
  /// The colour of a contact with a fixed shape, the sequence-th of its body in the strip.
  static std::uint32_t colour_of_static(const Strip& s, const StaticPair& static_pair, std::uint32_t sequence);
  /// How often the lanes were laid out. While the number stays the same, so do the lanes.
  std::uint64_t builds() const { return builds_; }
  void set_builds(std::uint64_t builds) { builds_ = builds; }

  PairLanes pairs;
  StaticLanes fixed;

 private:
  void colour_strip(PairTable& table, std::size_t strip);
  void place_strips(PairTable& table);
  void find_lanes(PairTable& table, std::size_t strip, const PairTable& old, const std::uint32_t* from);
  void find_entries();
  template <class Properties, class Each>
  void lay_out_pairs(PairTable& table, std::size_t strip, const Properties& properties, const Each& each);
  template <class LaneBefore>
  void lay_out_statics(PairTable& table, const TouchMemory& recent, std::size_t strip, const LaneBefore& lane_before);
  void recall(const Touch* touch, std::uint32_t id, ContactLanes& lanes, std::size_t lane);
  void make_room(std::size_t pair_lanes, std::size_t static_lanes) {
    pairs.make_room(model_, pair_lanes);
    fixed.make_room(model_, static_lanes);
  }

  const Surroundings s_;
  const Material& wall_;
  SolverBodies& solved_;
  const HeavyLoads& loads_;

  ContactModel model_;
  const BodyProperties* alike_ = nullptr;
  Column<std::uint32_t> used_{s_.memory};   // by slot: the colours that are taken
  Column<std::uint8_t> colour_{s_.memory};  // by pair
  Column<std::uint32_t> entry_{s_.memory};  // by slot: the entry in the table of properties, where bodies differ
  std::uint32_t colours_ = 0;
  std::uint64_t loaded_blocks_ = 0, builds_ = 0;
  std::vector<PairImpulse> lifted_;  // of the last strip
  std::vector<StripEdges> edges_;    // by strip: near discs, in this step
  bool any_loose_ = false;
  bool laying_ = false;  // the impulses of the last step are in the old columns
};

}  // namespace psim
