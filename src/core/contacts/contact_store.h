// The contacts of discs as the solver wants them: blocks of 8 lanes, by strip, then by colour, so that the lanes
// of a block share no body. Columns that the contact model of the plan does not read own no memory.
//
// Lanes and colours last as long as the PairTable, and impulses stay in their lanes meanwhile. When the lists are
// made anew, the impulses are carried over pair by pair.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "contacts/contact_model.h"
#include "contacts/solver_bodies.h"
#include "contacts/touch_memory.h"
#include "lists/heavy_loads.h"
#include "lists/pair_table.h"
#include "psim/desc.h"
#include "views.h"

namespace psim {

class ContactStore {
 public:
  template <class A>
  void describe(A& a);  ///< for saved states
  const ContactModel& model() const { return model_; }

  explicit ContactStore(MemoryMeter& meter);

  /// A layout in parts, since a step may be spread over frames: begin(), then colour() and lay_out(), each for strips
  /// [begin, end) from the first strip to the last; accept() ends it. Impulses are carried over from the `old` table;
  /// `from` maps new slots to old ones (null: they are the same). `alike` are the properties of all moving bodies, if
  /// they agree. Contacts of bodies in `loads` come last in their strip. `recent` has the impulses of contacts whose
  /// sides fell asleep or woke. O(pairs).
  void begin(const BodyStore& bodies, const SolverBodies& numbers, ContactModel model, const BodyProperties* alike,
             const HeavyLoads& loads, PairTable& table, WorkerPool& pool);
  void colour(const PairTable& table, std::size_t begin, std::size_t end, WorkerPool& pool);
  void lay_out(const BodyStore& bodies, const StaticShapes& statics, const Material& wall, PairTable& table,
               const PairTable& old, const std::uint32_t* from, const TouchMemory& recent, std::size_t begin,
               std::size_t end, WorkerPool& pool);
  /// The last strip gets other pairs when bodies are renewed (renewal.h): first lift() takes the impulses of its pairs,
  /// then renew() colours the new ones and lays them out with these impulses. With `static_contacts`, contacts with
  /// fixed shapes are laid out, too; StaticPair::contact is the lane that each had. All other contacts stay. O(pairs of
  /// the strip + strips + static contacts).
  void lift(const PairTable& table);
  void renew(const BodyStore& bodies, const StaticShapes& statics, const Material& wall, bool static_contacts,
             PairTable& table, WorkerPool& pool);
  /// Swaps the impulses of the old table and of the new one, as far as it is laid out. Both exist until accept() or
  /// give_up().
  void turn_back();
  void accept();                       ///< the new impulses count from now on
  void give_up() { laying_ = false; }  ///< the impulses that are in place count

  /// Makes room for so many contacts, which are laid out later.
  void spare(std::size_t pairs, std::size_t static_contacts);

  /// Forgets all impulses, since the model changed or the lists belong to another state of the world.
  void forget();

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
  Column<std::uint32_t> body;  ///< two numbers a lane, see SolverBodies
  Column<float> nx, ny, gap, rsum, impulse, mass, wa, wb, mu, friction, tmass, qa, qb, e, impact, start;
  // Static contacts, by lane.
  Column<std::uint32_t> s_body, s_shape;
  Column<float> s_nx, s_ny, s_gap, s_base_x, s_base_y, s_rsum, s_refresh, s_impulse, s_mass, s_wb, s_mu, s_friction,
      s_tmass, s_qb, s_e, s_impact, s_start;

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
  void lay_out_strip(const BodyStore& bodies, PairTable& table, const PairTable& old, const std::uint32_t* from,
                     const TouchMemory& recent, std::size_t strip);
  void lay_out_renewed(const BodyStore& bodies, PairTable& table);
  template <class Each>
  void place_pairs(const BodyStore& bodies, PairTable& table, std::size_t strip, const Each& each);
  template <class Before>
  void lay_out_statics(const BodyStore& bodies, const StaticShapes& statics, const Material& wall, PairTable& table,
                       const TouchMemory& recent, std::size_t strip, const Before& before);
  void fill_pair(const BodyStore& bodies, std::uint32_t a, std::uint32_t b, std::size_t lane);
  void pad_pair(std::size_t lane, std::uint32_t dummy);
  void fill_static(const BodyStore& bodies, const StaticShapes& statics, const Material& wall, const StaticPair& pair,
                   std::size_t lane);
  void pad_static(std::size_t lane, std::uint32_t dummy);
  void recall_static(const BodyStore& bodies, const StaticShapes& statics, const TouchMemory& recent,
                     const StaticPair& pair, std::size_t lane);
  template <class Each>
  void pad(const Counts& counts, const Counts& begin, const Each& each);
  bool is_loaded(const PairTable& table, std::size_t strip) const;
  std::uint32_t static_class(const Strip& s, std::uint32_t body, std::uint32_t sequence) const;
  void make_room(std::size_t pair_lanes, std::size_t static_lanes);

  ContactModel model_;
  const BodyProperties* alike_ = nullptr;
  const SolverBodies* numbers_ = nullptr;
  const HeavyLoads* loads_ = nullptr;
  Column<std::uint32_t> used_;   // by slot: the colours that are taken
  Column<std::uint8_t> colour_;  // by pair
  std::vector<Counts> counts_;   // by strip
  std::vector<Counts> static_counts_;
  Column<float> old_impulse_, old_friction_, old_s_impulse_, old_s_friction_, old_s_nx_, old_s_ny_;
  std::uint32_t pair_blocks_ = 0, static_blocks_ = 0, colours_ = 0;
  std::uint64_t pair_count_ = 0, static_count_ = 0, loaded_blocks_ = 0, builds_ = 0;
  struct Lifted {  // the impulses of a pair of the last strip
    std::uint32_t owner = 0, other = 0;
    float impulse = 0, friction = 0;
  };
  std::vector<Lifted> lifted_;
  bool laying_ = false;  // the impulses of the last step are in the old columns
};

}  // namespace psim
