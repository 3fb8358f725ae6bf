// The contacts of discs as the solver wants them: blocks of 8 lanes, by strip, then by colour, so that the lanes
// of a block share no body. Columns that the contact model of the plan does not read own no memory.
//
// Lanes and colours last as long as the PairTable, and impulses stay in their lanes meanwhile. When the lists are
// made anew, the impulses are carried over pair by pair.
#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "bodies/surroundings.h"
#include "contacts/contact_model.h"
#include "contacts/solver_bodies.h"
#include "contacts/touch_memory.h"
#include "lists/heavy_loads.h"
#include "lists/pair_table.h"
#include "psim/desc.h"
#include "views.h"

namespace psim {

class ContactStore {
  const BodyStore& b_;
  const StaticShapes& statics_;
  WorkerPool& pool_;
  const Material& wall_;
  const SolverBodies& numbers_;
  const HeavyLoads& loads_;
  MemoryMeter& meter_;  // stands before the columns, which take it

 public:
  /// For saved states. Their impulses are saved by pair (state/saved_contacts.h).
  auto fields() {
    return std::tie(model_.model, model_.bounce, pair_blocks_, static_blocks_, colours_, pair_count_, static_count_,
                    loaded_blocks_, builds_);
  }
  const ContactModel& model() const { return model_; }

  ContactStore(const Surroundings& s, const Material& wall, const SolverBodies& numbers, const HeavyLoads& loads)
      : b_(s.bodies),
        statics_(s.statics),
        pool_(s.pool),
        wall_(wall),
        numbers_(numbers),
        loads_(loads),
        meter_(s.memory) {}

  /// A layout in parts, since a step may be spread over frames: begin(), then colour() and lay_out(), each for strips
  /// [begin, end) from the first strip to the last; accept() ends it. Impulses are carried over from the `old` table;
  /// `from` maps new slots to old ones (null: they are the same). `alike` are the properties of all moving bodies, if
  /// they agree. Contacts of bodies in `loads` come last in their strip. `recent` has the impulses of contacts whose
  /// sides fell asleep or woke. O(pairs).
  void begin(ContactModel model, const BodyProperties* alike, PairTable& table);
  void colour(const PairTable& table, std::size_t begin, std::size_t end);
  void lay_out(PairTable& table, const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
               std::size_t begin, std::size_t end);
  /// The last strip gets other pairs when bodies are renewed (renewal.h): first lift() takes the impulses of its pairs,
  /// then renew() colours the new ones and lays them out with these impulses. With `static_contacts`, contacts with
  /// fixed shapes are laid out, too; StaticPair::contact is the lane that each had. All other contacts stay. O(pairs of
  /// the strip + strips + static contacts).
  void lift(const PairTable& table);
  void renew(bool static_contacts, PairTable& table);
  /// Swaps the impulses of the old table and of the new one, as far as it is laid out. Both exist until accept() or
  /// give_up().
  void turn_back() {
    if (laying_) swap_impulses();
  }
  void accept() {  ///< the new impulses count from now on
    if (laying_) ++builds_;
    laying_ = false;
  }
  void give_up() { laying_ = false; }  ///< the impulses that are in place count

  /// Makes room for so many contacts, which are laid out later.
  void spare(std::size_t pairs, std::size_t static_contacts);

  kernels::ContactView pairs();
  kernels::StaticContactView static_contacts();

  std::uint32_t pair_blocks() const { return pair_blocks_; }
  /// Blocks that a pass of the solver goes through.
  std::uint64_t pass_blocks() const { return pair_blocks_ + static_blocks_; }
  /// Blocks that the additional sweeps of a pass go through, summed over the sweeps.
  std::uint64_t loaded_blocks() const { return loaded_blocks_; }
  std::uint32_t static_blocks() const { return static_blocks_; }
  std::uint32_t colours() const { return colours_; }
  std::uint64_t pair_count() const { return pair_count_; }
  std::uint64_t static_count() const { return static_count_; }
  static constexpr std::uint32_t kMostColours = 31;
  /// The colour of a pair of the table that was laid out last. kMostColours or more: the pair is solved by itself.
  std::uint32_t colour_of_pair(std::uint32_t pair) const { return colour_[pair]; }
  /// The colour of a contact with a fixed shape, the sequence-th of its body in the strip.
  static std::uint32_t colour_of_static(const Strip& s, const StaticPair& static_pair, std::uint32_t sequence);
  /// Whether contacts have friction.
  bool rough() const { return model_.model == kernels::Model::rough; }
  std::size_t friction_bytes() const;
  /// How often the lanes were laid out. While the number stays the same, so do the lanes.
  std::uint64_t builds() const { return builds_; }
  void set_builds(std::uint64_t builds) { builds_ = builds; }

  // Pair contacts, by lane.
  Column<std::uint32_t> body{meter_};  ///< two numbers a lane, see SolverBodies
  Column<float> nx{meter_}, ny{meter_}, gap{meter_}, rsum{meter_}, impulse{meter_}, mass{meter_}, wa{meter_},
      wb{meter_}, mu{meter_}, friction{meter_}, tmass{meter_}, qa{meter_}, qb{meter_}, e{meter_}, impact{meter_},
      start{meter_};
  // Static contacts, by lane.
  Column<std::uint32_t> s_body{meter_}, s_shape{meter_};
  Column<float> s_nx{meter_}, s_ny{meter_}, s_gap{meter_}, s_base_x{meter_}, s_base_y{meter_}, s_rsum{meter_},
      s_refresh{meter_}, s_impulse{meter_}, s_mass{meter_}, s_wb{meter_}, s_mu{meter_}, s_friction{meter_},
      s_tmass{meter_}, s_qb{meter_}, s_e{meter_}, s_impact{meter_}, s_start{meter_};

 private:
  // The colours of pairs. A body with more partners overflows into blocks of one lane. Contacts under heavy loads have
  // the colours from kLoaded on.
  static constexpr std::uint32_t kColours = kMostColours, kLoaded = 16;
  static constexpr std::uint32_t kOverflow = kColours, kLoadedOverflow = kColours + 1;
  static constexpr std::uint32_t kClasses = kColours + 2;
  using Counts = std::array<std::uint32_t, kClasses>;
  struct Layout;

  void colour_strip(const PairTable& table, std::size_t strip);
  void place_strips(PairTable& table);
  void swap_impulses();
  void swap_statics();
  void lay_out_strip(PairTable& table, const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
                     std::size_t strip);
  void lay_out_renewed(PairTable& table);
  template <class Each>
  void place_pairs(PairTable& table, std::size_t strip, const Each& each);
  template <class Before>
  void lay_out_statics(PairTable& table, const TouchMemory& recent, std::size_t strip, const Before& before);
  void fill_pair(std::uint32_t a, std::uint32_t b, std::size_t lane);
  void pad_pair(std::size_t lane, std::uint32_t dummy);
  void fill_static(const StaticPair& pair, std::size_t lane);
  void pad_static(std::size_t lane, std::uint32_t dummy);
  void recall_static(const TouchMemory& recent, const StaticPair& pair, std::size_t lane);
  template <class List, class Each>
  void each_static(const Strip& s, List& list, const Each& each) const;
  template <class Each>
  void pad(const Counts& counts, const Counts& begin, const Each& each);
  bool is_loaded(const PairTable& table, std::size_t strip) const;
  std::uint32_t static_class(const Strip& s, std::uint32_t body, std::uint32_t sequence) const;
  void make_room(std::size_t pair_lanes, std::size_t static_lanes);

  ContactModel model_;
  const BodyProperties* alike_ = nullptr;
  Column<std::uint32_t> used_{meter_};   // by slot: the colours that are taken
  Column<std::uint8_t> colour_{meter_};  // by pair
  std::vector<Counts> counts_;           // by strip
  std::vector<Counts> static_counts_;
  Column<float> old_impulse_{meter_}, old_friction_{meter_}, old_s_impulse_{meter_}, old_s_friction_{meter_},
      old_s_nx_{meter_}, old_s_ny_{meter_};
  std::uint32_t pair_blocks_ = 0, static_blocks_ = 0, colours_ = 0;
  std::uint64_t pair_count_ = 0, static_count_ = 0, loaded_blocks_ = 0, builds_ = 0;
  struct Lifted {  // the impulses of a pair of the last strip
    std::uint32_t owner = 0, other = 0;
    float impulse = 0, friction = 0;
  };
  std::vector<Lifted> lifted_;
  bool laying_ = false;  // the impulses of the last step are in the old columns
};

/// The narrow phase of discs, at the start of a step: fills nx and ny and gap of every lane of `contacts`, and base and
/// refresh of static contacts, from lattice positions. `refresh` is the sideways motion, m, after which a normal is
/// computed anew within the step. A kernel computes pairs of discs; contacts with walls, segments and fixed discs are
/// computed one by one. O(candidates).
void narrow_phase(const Surroundings& s, SolverBodies& solved, const Walls& walls, float refresh,
                  const PairTable& table, ContactStore& contacts);

}  // namespace psim
