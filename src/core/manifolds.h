// Contacts of bodies that are not discs: which pairs there are, where they touch, and the blocks that
// the solver sweeps over.
//
//   collect   when lists change (begin_collect, sort_out, keep): takes pairs with such a body out of the discs' lists, keeping what is
//             known of pairs that were there before; drops pairs that a filter or a joint forbids
//   refresh   every step: normals, arms and gaps; gaps of what lies in lanes already go there
//   lay_out   every step, after the columns were found: what else changed goes into the lanes; colours and
//             blocks where the touching pairs did
//
// A manifold is kept as it is, with its normal and arms frozen in world axes, until its bodies have
// moved against each other by a share of their size or turned: only the gaps are taken anew. That is
// what lets stacks stand (docs/decisions/007-manifolds.md).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <optional>
#include <vector>

#include "body_store.h"
#include "collide.h"
#include "column.h"
#include "heavy_loads.h"
#include "kernel_table.h"
#include "narrow_phase.h"
#include "pair_table.h"
#include "psim/desc.h"
#include "sleepers.h"
#include "static_shapes.h"
#include "worker_pool.h"

namespace psim {

/// Two bodies, or a body and a piece of fixed geometry. A side that is static or kinematic is A; else
/// A has the lower id.
struct PairName {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  std::uint32_t a = kNone, b = kNone;  ///< slots; a is kNone for fixed geometry
  std::uint32_t shape = kNone;         ///< of fixed geometry: its number, or a wall
  std::uint32_t id_a = kNone, id_b = kNone;
  std::uint32_t owner = kNone;         ///< id: the smaller body, that has few such pairs
  std::uint16_t part_a = 0, part_b = 0;
  bool fixed_a = false;                ///< A is static or kinematic
  bool moved = false;                  ///< it is a renewed body's, which has it anew behind the last strip's

  bool same(const PairName& o) const {
    return id_a == o.id_a && id_b == o.id_b && shape == o.shape && part_a == o.part_a &&
           part_b == o.part_b && fixed_a == o.fixed_a;
  }
  std::uint32_t mark() const {  ///< tells most pairs of an owner apart
    return (id_a * 0x9E3779B1u) ^ (id_b * 0x85EBCA77u) ^ (shape * 0xC2B2AE3Du) ^
           (std::uint32_t{part_a} << 16 | part_b);
  }
};

/// And what is known of their contact.
struct ManifoldPair : PairName {
  std::uint32_t lane = kNone;          ///< 8 block + lane in the strip's blocks
  // As of the last time that the hulls were looked at:
  Manifold manifold;
  std::int32_t base_x = 0, base_y = 0;   ///< lattice steps from A (or 0) to B
  float base_dx = 0, base_dy = 0;        ///< m, offsets likewise
  Rotor turn_a, turn_b;
  float margin = -1;                     ///< m: gaps up to here were looked for; < 0: never looked
  float gap[2] = {};                     ///< m, now
  float impulse[2] = {}, friction[2] = {};
  float round_a = 0, round_b = 0;        ///< m: rounding of the two hulls
  bool active = false;                   ///< it has a lane
  bool ahead = false;                    ///< apart, and may meet within the step
  bool ghost = false;                    ///< below what the body rests on: no contact
  bool lasting = false;                  ///< the manifold may be kept while bodies move little
  bool changed = true;                   ///< since it was written into its lane
  /// In a column that stands on a moving body, on fixed ground, or in none.
  enum Column : std::uint8_t { kLoose, kOnMoving, kOnFixed };
  Column column = kLoose;
  Column was_column = kLoose;            ///< as it lies in its lane
  std::uint8_t rest_frames = 0;          ///< in which it is not
  static constexpr std::uint8_t kAlone = 0xFF;  ///< it is solved by itself
  std::uint8_t colour = kAlone;          ///< of its lane: run of StripBlocks::end x kColours + colour in it
  static constexpr std::uint32_t kColours = 32;
  std::uint8_t recalled = 0;             ///< points whose impulses come from before a body slept or woke
  // Where a side fell asleep or woke, contacts have another stiffness, and the same load would want another
  // overlap: that difference, m, added to the gaps. It lasts where A sleeps, else it fades.
  float offset[2] = {};
  static constexpr float kUnbalanced = -1, kBalanced = 0;
  float balanced = kBalanced;            ///< compliance that the offsets are for, or to be found
};

/// Whether the points of a manifold lie against the direction that its edge is read in, which is the same
/// seen from either body.
inline bool runs_backwards(const Manifold& m) {
  const bool steep = std::fabs(m.nx) > std::fabs(m.ny);
  const float sign = (steep ? m.nx : -m.ny) < 0 ? -1.0f : 1.0f;  // of the tangent (-ny, nx)
  const float x = m.point[1].bx - m.point[0].bx, y = m.point[1].by - m.point[0].by;
  return sign * (m.nx * y - m.ny * x) < 0;
}

/// Settings of a step.
struct ManifoldParams {
  double dt = 0;
  Vec2 gravity;
  const Lattice* lattice = nullptr;
  const StaticShapes* shapes = nullptr;
  const kernels::KernelTable* kernels = nullptr;
  Walls walls;
  Material wall;
  float warm = 1;
  bool changed = false;  ///< of the settings below, since the last step
  bool asleep = false;   ///< some body is
  // Compliance and push-out rate of contacts: between moving bodies, with fixed ones, and the same
  // under heavy loads.
  float soft[4] = {}, rate[4] = {};
  float bouncing_soft[2] = {}, bouncing_rate[2] = {};  // with restitution
  float column_soft[2] = {}, column_rate[2] = {};  // in columns on a moving body, on fixed ground
};

/// Whether two bodies, by id, are joined and do not collide.
using Joined = std::function<bool(std::uint32_t, std::uint32_t)>;

class Manifolds {
  friend struct Image;

 public:
  explicit Manifolds(MemoryMeter& meter) : kind_(meter), rotor_(meter), inner_(meter), used_(meter) {}

  /// What a strip's blocks are.
  struct StripBlocks {
    std::vector<kernels::ManifoldBlock> blocks;
    std::vector<std::uint32_t> active;  // pairs that have a lane, in this step
    std::vector<std::uint32_t> laid;    // pairs that have one in the blocks
    std::vector<std::uint32_t> rewrite; // active ones whose lane may hold what is not so any more, but for gaps
    // Ends of: pairs, pairs under heavy loads, pairs with a fixed side, those under heavy loads.
    std::uint32_t end[4] = {};
    std::uint32_t colours = 0;
    std::uint32_t points = 0;  // touching or near
  };

  /// How pairs were looked at in a step: lanes of the batches that kernels did, pairs in them, pairs one by one.
  struct Batches {
    std::uint64_t lanes = 0, used = 0, alone = 0;
    void add(const Batches& o) {
      lanes += o.lanes;
      used += o.used;
      alone += o.alone;
    }
  };
  const Batches& batches() const { return batches_; }

  /// Takes over the pairs of `table` that are not two discs and drops those that must not collide, in three
  /// parts, the last two of strips [begin, end), in order. `sorted`: slots changed. `recent`: impulses of those
  /// whose sides fell asleep or woke. O(pairs).
  void begin_collect(const BodyStore& bodies, bool any_filter, const PairTable& table, bool sorted,
                     WorkerPool& pool);
  void sort_out(const BodyStore& bodies, const StaticShapes& shapes, const Joined* joined, PairTable& table,
                std::size_t begin, std::size_t end, WorkerPool& pool);
  void keep(const BodyStore& bodies, const StaticShapes& shapes, const TouchMemory& recent,
            std::size_t begin, std::size_t end, WorkerPool& pool);

  /// Lists were made anew for some bodies, `found`, by slot: of what they are near now (renewal.h), pairs of slots
  /// and singles, leaves those that are a matter of discs and takes note of those that are manifolds.
  /// O(pairs of `found`), and once O(pairs).
  void sort_out_renewed(const BodyStore& bodies, const StaticShapes& shapes, const Joined* joined,
                        std::vector<std::uint64_t>& pairs, std::vector<SinglePair>& singles, WorkerPool& pool);
  /// They take the place of what those bodies had when they were found before. O(manifolds of renewed bodies).
  void put_renewed(const std::function<bool(std::uint32_t)>& found);
  /// Whether pairs that came back from a saved state are those of so many strips, as they were made again. In the
  /// middle of a step there may have been more of the last one, which are not there yet.
  bool fit(std::size_t strips);
  std::uint32_t renewed() const { return static_cast<std::uint32_t>(pairs_.size()) - own_end_; }

  /// Makes room for so many pairs to come.
  void spare(std::size_t pairs, std::size_t strips);
  /// Keeps the pairs as they are before a refresh that may be given up.
  void remember(WorkerPool& pool);
  /// The pairs as they were before they were collected or remembered, or as they are since: until accept() there
  /// are both.
  void turn_back() {
    if (both_) swap_pairs();
  }
  /// The present ones count.
  void accept() { both_ = collecting_ = false; }

  /// Manifolds for this step, pieces [begin, end) of look_pieces(): from the first to the last, in one go or
  /// spread over frames. O(pairs).
  void refresh(BodyStore& bodies, const ManifoldParams& params, std::size_t begin, std::size_t end,
               WorkerPool& pool);
  std::size_t look_pieces() const { return cuts_.size(); }
  std::size_t pairs_in(std::size_t piece) const { return cuts_[piece].end - cuts_[piece].begin; }
  /// Colours and blocks for this step. O(touching pairs).
  void lay_out(const BodyStore& bodies, const HeavyLoads& loads, const ManifoldParams& params,
               std::uint32_t dummies, WorkerPool& pool);

  /// Copies impulses from the blocks back to the pairs, before the blocks or the pairs change.
  void keep_impulses(WorkerPool& pool);
  /// All impulses are 0.
  void forget();
  /// There are no such pairs.
  void clear();
  /// Nor will there be: the memory is given back.
  void release();

  StripBlocks& strip(std::size_t index) { return strips_[index]; }
  std::size_t strips() const { return strips_.size(); }
  bool any() const { return points_ != 0; }
  /// Whether contacts under heavy loads are among them.
  bool loaded() const { return loaded_; }
  /// Blocks that a pass of the solver goes through.
  std::uint64_t pass_blocks() const { return pass_blocks_; }
  /// Lanes of a pass once the pairs that were looked at are laid out, about; and how many of the pairs are written
  /// into lanes for that.
  std::uint64_t expected_lanes() const;
  std::uint64_t expected_writes() const;
  std::uint64_t pair_count() const { return collecting_ ? old_pairs_.size() : pairs_.size(); }
  /// How many manifolds the next refresh will look at anew: as many as the last one, and new pairs.
  std::uint64_t expected_looks() const { return looks_ + new_pairs_; }
  std::uint64_t points() const { return points_; }
  std::uint32_t colours() const { return colours_; }
  const std::vector<ManifoldPair>& pairs() const { return pairs_; }
  std::span<const ManifoldPair> pairs_of(std::size_t strip) const {
    const auto at = [&](std::size_t k) { return pairs_.data() + std::min<std::size_t>(begin_[k], pairs_.size()); };
    return {at(strip), at(strip + 1)};
  }
  /// Whether the strips have all pairs, and no others: not where a collection was given up.
  bool by_strip() const { return !begin_.empty() && begin_.back() == pairs_.size(); }
  /// Whether a pair lies in its lane of a strip's blocks.
  bool lies(std::size_t strip, const ManifoldPair& pair) const {
    if (pair.lane == PairName::kNone || strip >= strips_.size()) return false;
    const std::vector<kernels::ManifoldBlock>& blocks = strips_[strip].blocks;
    const std::size_t at = pair.lane / kernels::kBlock;
    return at < blocks.size() && blocks[at].body[2 * (pair.lane % kernels::kBlock) + 1] == pair.b;
  }
  /// How many these are, or will be while they are collected.
  std::size_t count_of(std::size_t strip) const { return begin_[strip + 1] - begin_[strip]; }
  ManifoldPair& pair(std::uint32_t k) { return pairs_[k]; }
  /// A pair that was looked at is in a column, or in another kind of one.
  void set_column(std::uint32_t k, ManifoldPair::Column column);
  /// Pairs of a strip that are contacts in this step.
  const std::vector<std::uint32_t>& active_of(std::size_t strip) const {
    return strips_[strip].active;
  }
  std::size_t strip_of(std::uint32_t pair) const {
    return static_cast<std::size_t>(std::upper_bound(begin_.begin(), begin_.end(), pair) -
                                    begin_.begin()) - 1;
  }
  /// Whether a body rests on a plane that a fixed piece lies below.
  bool is_ghost(std::uint32_t slot, std::uint32_t shape) const {
    return std::binary_search(ghosts_.begin(), ghosts_.end(), std::uint64_t{slot} << 32 | shape);
  }
  bool has_corners(std::uint32_t slot) const { return (kind_[slot] & kShape) != 0; }
  /// Slots of the bodies that are not discs.
  const std::vector<std::uint32_t>& shaped() const { return shaped_; }
  /// Blocks of all strips.
  std::uint32_t blocks() const { return blocks_; }
  /// Cosine and sine of a body that is not a disc, at the frame's start.
  Rotor rotor(std::uint32_t slot) const {
    return {rotor_[2 * std::size_t{slot}], rotor_[2 * std::size_t{slot} + 1]};
  }
  std::size_t strip_count() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  /// Whether a pair carries an impulse or touches, as of the last step.
  bool closed(std::size_t strip, const ManifoldPair& pair) const {
    if (pair.lane == PairName::kNone) return false;
    const kernels::ManifoldBlock& c = strips_[strip].blocks[pair.lane / kernels::kBlock];
    const std::uint32_t l = pair.lane % kernels::kBlock;
    return !std::signbit(c.point[0].impulse[l]) || !std::signbit(c.point[1].impulse[l]);
  }
  /// Points of a strip that carry an impulse.
  std::uint64_t closed(std::size_t strip) const;
  /// Deepest overlap at the frame's start, m.
  float deepest() const;
  std::size_t bytes() const;
  std::size_t column_bytes() const { return kind_.bytes() + rotor_.bytes() + inner_.bytes() + used_.bytes(); }

 private:
  // What a slot holds, for fast looks: a plain disc, or something to look up.
  static constexpr std::uint8_t kDisc = 0, kShape = 1, kFiltered = 2, kHeld = 4, kSensor = 8;

  struct Found {  // of one strip, by collect: and where each was in the lists before
    std::vector<PairName> pairs;
    std::vector<std::uint32_t> before;
    std::vector<std::uint64_t> ghosts;
  };

  struct Cut {  // pairs of one strip
    std::uint32_t strip = 0, begin = 0, end = 0;
    std::uint32_t looks = 0;  // in the last refresh, at pairs that were known before
    bool whole = false;       // all of the strip's
    bool last = false;        // the last of the strip's
    Batches batches = {};     // of the last refresh
  };

  void cut();
  void sort_out_strip(const BodyStore& bodies, const StaticShapes& shapes, const Joined* joined,
                      PairTable& table, std::size_t strip);
  void place_pairs(std::size_t strips);
  bool collide_at_all(const BodyStore& bodies, const Joined* joined, std::uint32_t a,
                      std::uint32_t b) const;
  void index(const std::vector<ManifoldPair>& pairs, std::size_t count, std::uint32_t ids);
  enum class Fate { stays, manifold, goes };
  Fate fate(const BodyStore& bodies, const Joined* joined, std::uint32_t a, std::uint32_t b) const;
  Fate fate(const BodyStore& bodies, const StaticShapes& shapes, const Joined* joined, const SinglePair& single) const;
  void name(const BodyStore& bodies, std::uint32_t a, std::uint32_t b, PairName& pair) const;
  static void name(const BodyStore& bodies, const StaticShapes& shapes, const SinglePair& single, PairName& pair);
  template <class Each>
  void each_other_part(const BodyStore& bodies, const PairName& pair, const Each& each) const;
  static void recall_touch(const BodyStore& bodies, const StaticShapes& shapes,
                           const TouchMemory& recent, ManifoldPair& pair);
  static void take_recalled(ManifoldPair& pair);
  static void fade(const StaticShapes& shapes, ManifoldPair& pair);
  static void balance(const BodyStore& bodies, ManifoldPair& pair, const kernels::ManifoldBlock& block,
                      std::uint32_t lane);
  std::uint32_t recall(const PairName& pair, const std::vector<ManifoldPair>& pairs) const;
  struct Stand;    // manifold_look.h
  struct Waiting;
  void swap_pairs();
  void begin_refresh(const BodyStore& bodies, const ManifoldParams& params, WorkerPool& pool);
  void finish_strip(const BodyStore& bodies, const ManifoldParams& params, std::size_t strip);
  std::uint32_t look(const BodyStore& bodies, const ManifoldParams& params, std::uint32_t begin,
                     std::uint32_t end, Batches& batches);
  bool lasts(const BodyStore& bodies, const ManifoldParams& params, ManifoldPair& pair,
             Stand& now) const;
  void find(const BodyStore& bodies, const ManifoldParams& params, ManifoldPair& pair,
            const Stand& now, Waiting* waiting) const;
  void settle(const BodyStore& bodies, const ManifoldParams& params, Waiting& waiting,
              std::uint32_t kind) const;
  void take(const BodyStore& bodies, const ManifoldParams& params, ManifoldPair& pair,
            const Stand& now, const Manifold& found, const Hull* a, const Hull& b) const;
  const Hull& hull_of(const BodyStore& bodies, std::size_t slot, std::uint16_t part,
                      std::optional<Hull>& disc) const;
  static bool end_on(const ManifoldParams& params, const ManifoldPair& pair, const Hull& piece,
                     const Manifold& m, double& fx, double& fy);
  static void smooth_joint(const ManifoldParams& params, ManifoldPair& pair, const Hull& hull, Rotor q,
                           const Hull& piece, float margin);
  void judge(const BodyStore& bodies, const ManifoldParams& params, ManifoldPair& pair, float inner,
             float vx, float vy) const;
  void foresee(const BodyStore& bodies, const ManifoldParams& params, ManifoldPair& pair, const Hull& a,
               Rotor qa, const Hull& b, float dx, float dy, float mx, float my, float inner) const;
  void see_fixed(const BodyStore& bodies, const ManifoldParams& params, std::uint32_t begin,
                 std::uint32_t end, std::vector<std::uint64_t>& ghosts);
  void write_gaps(StripBlocks& strip, const ManifoldPair& pair) const;
  void soften(StripBlocks& strip, const ManifoldParams& params) const;
  void lay_out_strip(const BodyStore& bodies, const HeavyLoads& loads,
                     const ManifoldParams& params, std::uint32_t dummies, std::size_t strip);
  void fill(const BodyStore& bodies, const HeavyLoads& loads, const ManifoldParams& params,
            std::uint32_t dummies, std::size_t strip, ManifoldPair& pair);

  std::vector<ManifoldPair> pairs_, old_pairs_;
  std::vector<std::uint32_t> begin_;  // by strip: first of its pairs
  std::vector<Cut> cuts_;             // of the strips' pairs, in order
  std::uint32_t own_end_ = 0;         // first pair of renewed bodies that no strip has
  struct Renewed : PairName {
    std::uint32_t before = kNone;     // where its strip has it
  };
  std::vector<Renewed> renewed_;      // those that were found now
  std::vector<ManifoldPair> before_;  // and those that there were
  bool indexed_ = false;              // the index is of the strips' pairs
  // The pairs of the last lists by owner: entries of id k are [first_[k], first_[k + 1]).
  struct Entry {
    std::uint32_t mark = 0, pair = 0;
  };
  std::vector<std::uint32_t> first_, owner_;
  std::vector<Entry> entries_;
  std::vector<Found> found_;
  std::vector<std::uint64_t> ghosts_;  // slot << 32 | fixed piece, ascending
  std::vector<StripBlocks> strips_;
  std::vector<std::uint8_t> special_; // by strip: some of its bodies are no plain discs
  std::vector<std::uint8_t> stale_;   // by strip: its blocks are of other pairs
  Column<std::uint8_t> kind_;         // by slot
  Column<float> rotor_;               // by slot, records
  Column<float> inner_;               // by slot: m, what counts as its inner radius in this step
  Column<std::uint32_t> used_;        // by slot: colours taken
  std::vector<std::uint32_t> shaped_; // slots of bodies that are not discs
  std::uint64_t points_ = 0;
  std::uint64_t looks_ = 0, new_pairs_ = 0;  // of the last refresh; since then
  Batches batches_;                   // of the last refresh
  float g_ = 0;                       // m/s^2, in this step
  bool any_filter_ = false, loaded_ = false;
  bool both_ = false;                 // old_pairs_ are those of the last step
  bool collecting_ = false;           // and pairs_ not all there yet
  bool laid_ = false;                 // impulses are in the blocks, not in the pairs
  std::uint32_t colours_ = 0, blocks_ = 0;
  std::uint64_t pass_blocks_ = 0;
};

}  // namespace psim
