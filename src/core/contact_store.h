// Contacts as the solver wants them: blocks of 8 lanes, by strip, then by colour, so that the lanes
// of a block share no body. Columns that the plan's model does not read own no memory.
//
// The lists and colours last as long as the PairTable; impulses stay in their place meanwhile and
// are carried over, pair by pair, when the lists are made again.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "body_store.h"
#include "column.h"
#include "heavy_loads.h"
#include "pair_table.h"
#include "psim/desc.h"
#include "sleepers.h"
#include "solver_bodies.h"
#include "static_shapes.h"
#include "views.h"
#include "worker_pool.h"

namespace psim {

/// Which columns contacts have.
struct ContactModel {
  kernels::Model model = kernels::Model::plain;
  bool bounce = false;
  friend bool operator==(const ContactModel&, const ContactModel&) = default;
};

class ContactStore {
  friend struct Image;

 public:
  explicit ContactStore(MemoryMeter& meter);

  /// Colours the pairs of `table`, lays the blocks out and carries impulses over from the old
  /// table (`from` maps new slots to old ones; null: the same). `alike`: the cold data of all moving bodies, if
  /// they agree. Contacts of bodies in `loads` come last in their strip. `recent`: impulses of those
  /// whose sides fell asleep or woke. O(pairs).
  void build(BodyStore& bodies, const SolverBodies& numbers, const StaticShapes& shapes,
             const Material& wall, ContactModel model, const Surface* alike,
             const HeavyLoads& loads, PairTable& table, const PairTable& old,
             const std::uint32_t* from, const TouchMemory& recent, WorkerPool& pool);

  /// The same in parts, for a step spread over frames: colours of strips [begin, end) in the order of
  /// phases, then their lanes; each goes from the first strip to the last.
  void begin(const BodyStore& bodies, const SolverBodies& numbers, ContactModel model, const Surface* alike,
             const HeavyLoads& loads, PairTable& table, WorkerPool& pool);
  void colour(const PairTable& table, std::size_t begin, std::size_t end, WorkerPool& pool);
  void lay_out(const BodyStore& bodies, const StaticShapes& shapes, const Material& wall, PairTable& table,
               const PairTable& old, const std::uint32_t* from, const TouchMemory& recent,
               std::size_t begin, std::size_t end, WorkerPool& pool);
  /// The last strip has other pairs, in renew() (renewal.h): first lift() takes what they carry, then renew() colours
  /// them and lays them out with it. `singles`: so are contacts with fixed shapes, which carry what
  /// SinglePair::contact says that they did. All others stay. O(pairs of the strip + strips + singles).
  void lift(const PairTable& table);
  void renew(const BodyStore& bodies, const StaticShapes& shapes, const Material& wall, bool singles, PairTable& table,
             WorkerPool& pool);
  /// Impulses as the old table says, or as the new one does, as far as they are laid out: until accept() or
  /// give_up() there are both.
  void turn_back();
  void accept();                         ///< The new ones count from now on.
  void give_up() { laying_ = false; }    ///< Those that are in place do.

  /// Makes room for so many contacts to come.
  void spare(std::size_t pairs, std::size_t singles);

  /// Forgets all impulses (the model changed, or the lists are of another world state).
  void forget();

  kernels::ContactView pairs();
  kernels::SingleView singles();

  std::uint32_t pair_blocks() const { return pair_blocks_; }
  /// Blocks that a pass of the solver goes through.
  std::uint64_t pass_blocks() const { return pair_blocks_ + single_blocks_; }
  /// Those that more sweeps of a pass go through, in all these.
  std::uint64_t loaded_blocks() const { return loaded_blocks_; }
  std::uint32_t single_blocks() const { return single_blocks_; }
  std::uint32_t colours() const { return colours_; }
  std::uint64_t pair_count() const { return pair_count_; }
  std::uint64_t single_count() const { return single_count_; }
  static constexpr std::uint32_t kMostColours = 31;
  /// Of a pair of the table that was laid out last; kMostColours or more: it is solved by itself.
  std::uint32_t colour_of_pair(std::uint32_t pair) const { return colour_[pair]; }
  /// Of a contact with a fixed shape, the sequence-th of its body in the strip.
  static std::uint32_t colour_of_single(const Strip& s, const SinglePair& single, std::uint32_t sequence);
  /// Whether contacts have friction.
  bool rough() const { return model_.model == kernels::Model::rough; }
  std::size_t friction_bytes() const;
  /// How often the lanes were laid out: while it stays, so do they.
  std::uint64_t builds() const { return builds_; }
  void set_builds(std::uint64_t builds) { builds_ = builds; }

  // Pair contacts, by lane.
  Column<std::uint32_t> body;  ///< two a lane, as SolverBodies numbers them
  Column<float> nx, ny, gap, rsum, impulse, mass, wa, wb, mu, friction, tmass, qa, qb, e, impact,
      start;
  // Single contacts, by lane.
  Column<std::uint32_t> s_body, s_shape;
  Column<float> s_nx, s_ny, s_gap, s_base_x, s_base_y, s_rsum, s_refresh, s_impulse, s_mass, s_wb,
      s_mu, s_friction, s_tmass, s_qb, s_e, s_impact, s_start;

 private:
  // Colours a pair can have; a body with more partners than that overflows into blocks of one lane.
  // Under heavy loads the colours from kLoaded on are theirs.
  static constexpr std::uint32_t kColours = kMostColours, kLoaded = 16;
  static constexpr std::uint32_t kOverflow = kColours, kLoadedOverflow = kColours + 1;
  static constexpr std::uint32_t kClasses = kColours + 2;
  using Counts = std::array<std::uint32_t, kClasses>;
  struct Layout;

  void colour_strip(const PairTable& table, std::size_t strip);
  void place_strips(PairTable& table);
  void swap_impulses();
  void swap_singles();
  void lay_out_strip(const BodyStore& bodies, PairTable& table, const PairTable& old,
                     const std::uint32_t* from, const TouchMemory& recent, std::size_t strip);
  void lay_out_renewed(const BodyStore& bodies, PairTable& table);
  template <class Each>
  void place_pairs(const BodyStore& bodies, PairTable& table, std::size_t strip, const Each& each);
  template <class Before>
  void lay_out_singles(const BodyStore& bodies, const StaticShapes& shapes, const Material& wall, PairTable& table,
                       const TouchMemory& recent, std::size_t strip, const Before& before);
  void fill_pair(const BodyStore& bodies, std::uint32_t a, std::uint32_t b, std::size_t lane);
  void pad_pair(std::size_t lane, std::uint32_t dummy);
  template <class Each>
  void pad(const Counts& counts, const Counts& begin, const Each& each);
  bool is_loaded(const PairTable& table, std::size_t strip) const;
  std::uint32_t single_class(const Strip& s, std::uint32_t body, std::uint32_t sequence) const;
  void make_room(std::size_t pair_lanes, std::size_t single_lanes);

  ContactModel model_;
  const Surface* alike_ = nullptr;
  const SolverBodies* numbers_ = nullptr;
  const HeavyLoads* loads_ = nullptr;
  Column<std::uint32_t> used_;   // by slot: colours taken
  Column<std::uint8_t> colour_;  // by pair
  std::vector<Counts> counts_;   // by strip
  std::vector<Counts> single_counts_;
  Column<float> old_impulse_, old_friction_, old_s_impulse_, old_s_friction_, old_s_nx_, old_s_ny_;
  std::uint32_t pair_blocks_ = 0, single_blocks_ = 0, colours_ = 0;
  std::uint64_t pair_count_ = 0, single_count_ = 0, loaded_blocks_ = 0, builds_ = 0;
  struct Lifted {  // of a pair of the last strip
    std::uint32_t owner = 0, other = 0;
    float impulse = 0, friction = 0;
  };
  std::vector<Lifted> lifted_;
  bool laying_ = false;  // the impulses of the last step are in the old columns
};

}  // namespace psim
