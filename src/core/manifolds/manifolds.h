// Contacts of bodies that are not discs: which pairs there are, where they touch, and the blocks that
// the solver sweeps over.
//
//   collect   when lists change (begin_collect, sort_out, keep): takes pairs with such a body out of the lists of
//             discs and keeps what is known of pairs that were there before; drops pairs that a filter or a joint
//             forbids
//   refresh   every step: normals, arms and gaps; the gaps of pairs in lanes go there at once
//   lay_out   every step, after the stacks were found: writes all other changes into the lanes; makes colours and
//             blocks anew where other pairs touch
//
// A manifold is kept as it is, with its normal and arms frozen in world axes, until its bodies have
// moved against each other by a share of their size or turned: only the gaps are computed anew. Because of
// this, stacks stand (docs/decisions/007-manifolds.md).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "bodies/surroundings.h"
#include "contacts/touch_memory.h"
#include "kernel_table.h"
#include "lists/heavy_loads.h"
#include "lists/pair_table.h"
#include "manifolds/decisions.h"
#include "manifolds/manifold_pair.h"
#include "manifolds/part_boxes.h"
#include "manifolds/part_search.h"
#include "manifolds/steady_lanes.h"
#include "psim/desc.h"
#include "psim/pre_solve.h"
#include "views.h"

namespace psim {

/// Frames for which a contact stays out of stacks after an impact or a short step of theirs.
inline constexpr std::uint8_t kRestFrames = 8;

inline constexpr float kRocking = 1e-3f;    ///< rad in a step: bodies that turn less against each other do not rock
inline constexpr float kTouching = 0.002f;  ///< share of the inner radius: hulls with a smaller gap touch

/// Shapes that pass each other by more of their sizes in a substep may have more impacts than the impact sweeps settle.
/// From fixed geometry, those bounce in the sweeps that go no further in a whole step, others in continuous collision.
inline constexpr float kMostSizes = 4;

/// Compliance and push-out rate of a contact, see ManifoldBlock.
struct Stiffness {
  float soft = 0, rate = 0;
};

/// The settings of a step.
struct ManifoldParams {
  double dt = 0;
  Vec2 gravity;
  Walls walls;
  bool changed = false;                 ///< the settings below changed since the last step
  bool asleep = false;                  ///< some body sleeps
  bool locks = false;                   ///< some body may be locked along an axis
  bool surfaces = false;                ///< some surfaces run, resist rolling, are solid from one side or ask the host
  bool asking = false;                  ///< some ask the host
  const PreSolve* pre_solve = nullptr;  ///< whom they ask; empty if nobody answers
  Stiffness plain[4];      ///< contacts between moving bodies, with fixed ones, and the same under heavy loads
  Stiffness bouncing[2];   ///< contacts with restitution: between moving bodies, with fixed ones
  Stiffness in_stacks[2];  ///< contacts of stacks on a moving body, on fixed ground
};

/// Whether two bodies, by id, are joined and do not collide.
using Joined = std::function<bool(std::uint32_t, std::uint32_t)>;

struct ManifoldsAround;

class Manifolds {
  const Surroundings s_;

 public:
  void describe(class Archive& a, const ManifoldsAround& around);  ///< for saved states

  explicit Manifolds(const Surroundings& s) : s_(s) {}

  /// The blocks of a strip.
  struct StripBlocks {
    std::vector<kernels::ManifoldBlock> blocks;
    std::vector<kernels::SurfaceBlock> surfaces;  // as many, in worlds that have such surfaces
    std::vector<std::uint32_t> active;            // pairs that have a lane in this step
    std::vector<std::uint32_t> laid;              // pairs that have a lane in the blocks as they are
    std::vector<std::uint32_t> idle;              // pairs that were active a short while ago, and keep lanes
    std::vector<std::uint32_t> fresh;             // active pairs that were not so in the last step
    std::vector<std::uint32_t> rewrite;           // active pairs whose lane may be out of date in more than its gaps
    std::vector<std::uint32_t> landing;           // pairs whose bodies may meet in this step
    std::vector<std::uint32_t> open;              // pairs that are open in one of two points
    std::vector<std::uint32_t> watched;           // contacts with kinematic bodies, and pairs deep in something fixed
    // The sides of active pairs with a body of another strip: slots, or the ground.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> across;
    // The ends of four runs: pairs, pairs under heavy loads, pairs with a fixed side, the same under heavy loads.
    std::uint32_t end[4] = {};
    std::uint32_t colours = 0;
    std::uint32_t points = 0;  // points that touched or were near when the blocks were made, and idle pairs
    std::uint32_t turned = 0;  // touching pairs that came to stand, or to fall, by how their bodies hang together
    bool others = false;       // some pairs are active that were not so in the last step, or the other way round
    SteadyLanes lasting;
  };

  /// How the pairs of a step were looked at.
  struct Looks {
    std::uint64_t lanes = 0;  ///< lanes of the batches of kernels
    std::uint64_t used = 0;   ///< pairs in these lanes
    std::uint64_t alone = 0;  ///< pairs that were looked at one by one
    std::uint64_t again = 0;  ///< all pairs that were known before and looked at anew
    Looks& operator+=(const Looks& o) {
      lanes += o.lanes;
      used += o.used;
      alone += o.alone;
      again += o.again;
      return *this;
    }
  };
  const Looks& looks() const { return looks_; }

  /// What the blocks of all strips have.
  struct Totals {
    std::uint64_t points = 0;       ///< those of all strips
    std::uint64_t pass_blocks = 0;  ///< blocks that a pass of the solver goes through
    std::uint32_t blocks = 0, colours = 0;
    bool loaded = false;  ///< some contacts are under heavy loads
  };
  const Totals& totals() const { return totals_; }
  bool any() const { return totals_.points != 0; }

  /// Takes over the pairs of `table` that are not two discs, and drops those that must not collide. Three parts; the
  /// last two go over strips [begin, end) in order. `sorted`: slots changed. `recent` has the impulses of contacts
  /// whose sides fell asleep or woke. O(pairs).
  void begin_collect(const CollectSettings& settings, const PairTable& table, bool sorted);
  /// The body of a slot has joints. After begin_collect().
  void note_tied(std::size_t slot) { kind_[slot] |= kTied; }
  void sort_out(const Joined* joined, PairTable& table, std::size_t begin, std::size_t end);
  void keep(const TouchMemory& recent, std::size_t begin, std::size_t end);

  /// Whether bodies of many parts have not turned too far for the lists, and will not within `time` seconds.
  bool parts_serve(float time) const { return parts_.serve(time); }
  /// Which bodies of a few parts have, or will have: slots, ascending. Their lists must be made anew.
  std::span<const std::uint32_t> turned_parts(float time) { return parts_.find_turned(time); }
  /// The lists were made anew, with such margins, for the bodies in `slots`, ascending (renewal.h).
  void note_renewed(std::span<const std::uint32_t> slots, const kernels::ReachParams& margin);
  /// Takes the manifolds out of the new pairs and static contacts of these bodies, and notes them. The contacts of discs
  /// stay there. O(pairs of such bodies), and once O(pairs).
  void sort_out_renewed(const Joined* joined, std::vector<std::uint64_t>& pairs, std::vector<StaticPair>& near);
  /// The noted manifolds replace those that these bodies had before. O(manifolds of renewed bodies).
  void put_renewed(const std::function<bool(std::uint32_t)>& found);
  /// Whether the pairs of a saved state are those of so many strips, which were made again. In the middle of a step the
  /// last strip may have had more pairs, which are not there yet.
  bool fit(std::size_t strips);

  /// Least cosine between the normal of a contact and the direction of a side that is solid, for a body that comes.
  static constexpr double kSolidSide = 0.5;
  /// The direction, in world axes, against which a body must come to meet side A or B of a pair; 0: any.
  Vec2 one_way_of(const PairName& pair, bool of_b) const;
  Sides sides_of(const PairName& pair) const {
    const BodyProperties& of_b = s_.bodies.properties(pair.id_b);
    return sides_of(pair, pair.of_wall() ? of_b : s_.bodies.properties(pair.id_a), of_b);
  }
  /// The same, where the caller knows the properties of both.
  Sides sides_of(const PairName& pair, const BodyProperties& of_a, const BodyProperties& of_b) const {
    Sides sides = psim::sides_of(pair, s_, of_a, of_b);
    if (!decisions_.empty()) sides.decided = decisions_.surface_of(name_of(pair, s_.statics));
    return sides;
  }
  /// What the host decided of contacts.
  const Decisions& decisions() const { return decisions_; }
  /// A body goes.
  void forget_decisions(std::uint32_t id) { decisions_.forget(id); }

  /// Makes room for so many pairs.
  void spare(std::size_t pairs, std::size_t strips);
  /// Keeps the pairs as they are before a refresh that may be given up.
  void remember();
  /// Swaps the pairs as they were before collect or remember() and as they are since. Both exist until accept().
  void turn_back() {
    if (both_) old_pairs_.swap(pairs_);
    fixed_known_ = false;
  }
  /// The present pairs count from now on.
  void accept() { both_ = collecting_ = false; }

  /// Makes the manifolds of this step: pieces [begin, end) of look_pieces(), from the first to the last, in one go or
  /// spread over frames. O(pairs).
  void refresh(const ManifoldParams& params, std::size_t begin, std::size_t end);
  std::size_t look_pieces() const { return cuts_.size(); }
  std::size_t pairs_in(std::size_t piece) const { return cuts_[piece].end - cuts_[piece].begin; }
  /// Finds the contacts with kinematic bodies that turn fast anew, as they will be `ahead`, s, from now. O(such contacts).
  void follow_turning(const kernels::BodyView& view, double ahead);
  /// Puts the manifold that a pair will have `ahead`, s, from now into its lane. u: m/s, of B against A.
  void foretell(ManifoldPair& pair, kernels::ManifoldBlock& c, const Manifold& m, const kernels::BodyView& view, Vec2 u,
                double ahead) const;
  /// Makes of a manifold with the end of a segment, found within the step, that with its face, or none. `start` and `way`
  /// lead from A to B, at the start of the step and then.
  void fit_within_step(const ManifoldPair& pair, Manifold& m, const Hull& a, const Hull& hull_b, Rotor qb, Vec2 start,
                       Vec2 way) const;
  /// Finds which contacts stand on fixed ground, and whether loads change as a whole in this step, once all pairs were
  /// looked at. O(active pairs) if others are active than in the last step.
  void find_footing();
  /// Whether find_footing() will go over all contacts; then it needs the joints: pairs of slots, kNone where a joint is held.
  bool footing_is_old() const;
  std::vector<std::array<std::uint32_t, 2>> ties;
  /// Most of the contacts were put there since the last step, or got or lost their footing in it, so that they carry
  /// something else than what they will.
  bool cold() const { return cold_; }
  /// Makes colours and blocks for this step. O(touching pairs).
  void lay_out(const HeavyLoads& loads, const ManifoldParams& params, std::uint32_t dummies);

  /// Copies impulses and gaps from the blocks back to the pairs, before the blocks or the pairs change.
  void keep_impulses();
  /// Gives the pairs that are steady the gaps that were found for this step, and their impulses.
  void catch_up();
  void catch_up(const StripBlocks& strip, std::uint32_t k);  ///< the same for one pair
  /// The lane of a pair of this strip that is steady in this step (SteadyLanes), or kNone.
  std::uint32_t steady_lane(const StripBlocks& strip, std::uint32_t k) const {
    const std::uint32_t lane = k < known_lane_.size() ? known_lane_[k] : PairName::kNone;
    return lane != PairName::kNone && strip.lasting.is_steady(lane) ? lane : PairName::kNone;
  }
  /// Drops all pairs.
  void forget();
  /// Drops all pairs and what was made of them.
  void clear();
  /// Drops all pairs and gives the memory back.
  void release();

  StripBlocks& strip(std::size_t index) { return strips_[index]; }
  const StripBlocks& strip(std::size_t index) const { return strips_[index]; }
  std::size_t strip_count() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  /// About how many lanes a pass has once the pairs that were looked at are laid out, and how many pairs must be
  /// written into lanes for that.
  std::uint64_t expected_lanes() const;
  std::uint64_t expected_writes() const;
  std::uint64_t pair_count() const { return collecting_ ? old_pairs_.size() : pairs_.size(); }
  /// An estimate of how many pairs the next refresh looks at: as many as the last one, plus the new pairs.
  std::uint64_t expected_looks() const { return looks_.again + new_pairs_; }
  const std::vector<ManifoldPair>& pairs() const { return pairs_; }
  ManifoldPair& pair(std::uint32_t k) { return pairs_[k]; }
  std::span<const ManifoldPair> pairs_of(std::size_t strip) const {
    const auto at = [&](std::size_t k) { return pairs_.data() + std::min<std::size_t>(begin_[k], pairs_.size()); };
    return {at(strip), at(strip + 1)};
  }
  /// Whether all pairs belong to strips. They do not if a collection was given up.
  bool by_strip() const { return !begin_.empty() && begin_.back() == pairs_.size(); }
  /// Whether a pair has a lane in the blocks of a strip.
  bool lies(std::size_t strip, const ManifoldPair& pair) const {
    if (pair.lane == PairName::kNone || strip >= strips_.size()) return false;
    const std::vector<kernels::ManifoldBlock>& blocks = strips_[strip].blocks;
    const std::size_t at = pair.lane / kernels::kBlock;
    return at < blocks.size() && blocks[at].body[2 * (pair.lane % kernels::kBlock) + 1] == pair.b;
  }
  /// The number of pairs, or the expected number while they are collected.
  std::size_t count_of(std::size_t strip) const { return begin_[strip + 1] - begin_[strip]; }
  std::size_t strip_of(std::uint32_t pair) const {
    return static_cast<std::size_t>(std::upper_bound(begin_.begin(), begin_.end(), pair) - begin_.begin()) - 1;
  }
  /// Sets whether a pair that was looked at is in a stack, and in which kind.
  void set_stack_role(std::uint32_t k, ManifoldPair::StackRole role);
  /// A pair of a strip that was looked at stays out of stacks for some frames.
  void hold_out(std::uint32_t k, std::size_t strip);
  bool has_corners(std::size_t slot) const { return (kind_[slot] & kShape) != 0; }
  Hull floor_of(const ManifoldPair& pair) const;
  /// Slots of the bodies that are not discs.
  const std::vector<std::uint32_t>& shaped() const { return shaped_; }
  /// Cosine and sine of a body that is not a disc, at the start of the frame.
  Rotor rotor(std::size_t slot) const { return {rotor_[2 * slot], rotor_[2 * slot + 1]}; }
  /// Whether a pair carried an impulse or touched in the last step.
  bool closed(std::size_t strip, const ManifoldPair& pair) const {
    if (!lies(strip, pair)) return false;  // there may have been no room for the blocks
    const kernels::ManifoldBlock& c = strips_[strip].blocks[pair.lane / kernels::kBlock];
    const std::uint32_t l = pair.lane % kernels::kBlock;
    return !std::signbit(c.point[0].impulse[l]) || !std::signbit(c.point[1].impulse[l]);
  }
  /// The number of points of a strip that carry an impulse.
  struct Closed {
    std::uint64_t points = 0, pairs = 0;
  };
  Closed closed(std::size_t strip) const;
  std::size_t bytes() const;
  std::size_t column_bytes() const {
    return kind_.bytes() + rotor_.bytes() + inner_.bytes() + used_.bytes() + boxes_.bytes();
  }

 private:
  // The kind of the body in each slot, for fast tests: a plain disc, or a body to look up.
  // kParts: its parts differ.
  // kTied: it has joints.
  static constexpr std::uint8_t kDisc = 0, kShape = 1, kFiltered = 2, kKinematic = 4, kSensor = 8, kParts = 16,
                                kTied = 32;

  struct Cut {  // a piece of the pairs of one strip
    std::uint32_t strip = 0, begin = 0, end = 0;
    Looks looks;  // of the last refresh
  };
  struct Sorter;  // manifold_pairs.cpp
  struct Look;    // manifold_look.cpp
  struct Layout;  // manifold_layout.cpp

  bool asks(const PairName& pair) const;
  bool is_tied(const PairName& pair) const {
    return ((kind_[pair.b] | (pair.of_piece() ? 0 : kind_[pair.a])) & kTied) != 0;
  }
  NewContact shown(const ManifoldPair& pair, const ContactName& name) const;
  void ask(const PreSolve& pre_solve);
  void check_pair(Archive& a, const ManifoldPair& pair, const ManifoldsAround& around) const;
  void follow_from_pairs();
  void check_strip(Archive& a, std::size_t strip, const ManifoldsAround& around) const;
  void cut();
  void turn_shapes();
  void box_shapes();
  void box_parts();
  void place_pairs(std::size_t strips);
  Looks look(const ManifoldParams& params, const Cut& cut);
  void look_in_lanes(const ManifoldParams& params, bool allowed);
  bool may_be_steady(std::uint32_t k) const;
  void note_steady(std::size_t strip);
  void forget_steady(std::size_t strip);
  void forget_steady(std::uint32_t k, std::size_t strip);
  void catch_up(std::size_t strip);
  static void take_from_lane(const StripBlocks& strip, ManifoldPair& pair);
  bool note_contact(StripBlocks& strip, std::uint32_t k, bool laid);
  static void open_lane(kernels::ManifoldBlock& block, std::uint32_t lane);
  template <class At>
  void see_fixed(const ManifoldParams& params, std::size_t count, const At& at) const;
  // Lists the fixed sides of all bodies, by body, if some are kinematic: those lie among the pairs of two bodies.
  // all(each) calls each(name, k) for every pair, k ascending. They are counted by body.
  template <class All>
  void list_fixed(const All& all) {
    fixed_.clear();
    fixed_known_ = true;
    if (!any_kinematic_) return;
    const auto each_fixed = [&](const auto& each) {
      all([&](const PairName& p, std::uint32_t k) {
        if (p.fixed_a && !p.moved) each(p.b, k);
      });
    };
    std::fill_n(used_.data(), s_.bodies.count, 0u);
    each_fixed([&](std::uint32_t slot, std::uint32_t) { ++used_[slot]; });
    std::uint32_t sum = 0;
    for (std::size_t slot = 0; slot < s_.bodies.count; ++slot) sum += std::exchange(used_[slot], sum);
    fixed_.resize(sum);
    each_fixed([&](std::uint32_t slot, std::uint32_t k) { fixed_[used_[slot]++] = std::uint64_t{slot} << 32 | k; });
  }
  auto fixed_of(std::uint32_t slot) const {
    const std::uint64_t first = std::uint64_t{slot} << 32;
    return std::pair(std::ranges::lower_bound(fixed_, first), std::ranges::upper_bound(fixed_, first | 0xFFFFFFFFu));
  }
  float inner_of(std::size_t slot) const { return has_corners(slot) ? inner_[slot] : s_.bodies.radius[slot]; }
  // The pairs of a strip with fixed pieces, which lie behind its other pairs, then those of renewed bodies.
  std::array<std::pair<std::uint32_t, std::uint32_t>, 2> pieces_of(std::size_t strip) const {
    const std::uint32_t begin = begin_[strip], end = begin_[strip + 1], own = std::clamp(own_end_, begin, end);
    const auto run = [&](std::uint32_t from, std::uint32_t to) {
      std::uint32_t first = to;
      while (first != from && pairs_[first - 1].of_piece()) --first;
      return std::pair(first, to);
    };
    return {run(begin, own), run(own, end)};
  }
  void see_ground(const ManifoldParams& params, std::size_t strip);
  void see_all_ground(const ManifoldParams& params);
  float half_time(const ManifoldPair& pair, float dt) const;
  bool halfway(const ManifoldPair& pair, float dt, Manifold& m, float (&lead)[2]) const;
  bool turns_fast(const ManifoldPair& pair, float dt) const;
  void list_turning(float dt);
  void put_turned(const ManifoldPair& pair, const Manifold& m, kernels::ManifoldBlock& c, std::uint32_t l,
                  const kernels::BodyView& view, Vec2 moved, Vec2 u, double ahead) const;
  void order_by_approach(std::size_t strip);
  void order_scattered(std::vector<std::uint32_t>& active, const auto& of_ground, const auto& less);
  void finish_strip(const ManifoldParams& params, std::size_t strip);
  void find_standing();
  std::pair<std::uint32_t, std::uint32_t> sides_of_active(const StripBlocks& strip, std::uint32_t k) const;
  bool stand_as_before();
  void unite(std::uint32_t slot_a, std::uint32_t slot_b);
  void name_sets();
  bool touches(const ManifoldPair& pair) const;
  bool touch_fewer(std::size_t many) const;
  template <class Visit>
  void each_active(const Visit& visit) {
    for (std::size_t s = 0; s < strip_count(); ++s) {
      for (const std::uint32_t k : strips_[s].active) visit(s, k);
    }
  }

  std::vector<ManifoldPair> pairs_, old_pairs_;
  PartSearch parts_{s_};
  PartBoxes boxes_{s_};
  bool boxed_ = false;       // those of the bodies that the lists are for are there
  bool long_known_ = false;  // long_ is that of shaped_
  Decisions decisions_;
  Walls walls_;
  std::vector<std::uint32_t> begin_;  // by strip: the first of its pairs
  std::vector<Cut> cuts_;             // the pieces of all strips, in order
  std::uint32_t own_end_ = 0;         // the first pair of renewed bodies that belongs to no strip
  PairIndex index_;                   // of the last lists while pairs are collected, of the present ones in renewals
  bool indexed_ = false;              // the index is that of the present pairs
  std::vector<std::vector<FoundPair>> found_;  // by strip: pairs that collect found
  std::vector<FoundCounts> counts_;            // by strip, of these
  std::vector<SlotRange> ranges_;              // by strip, if lists were made since the state came back
  std::vector<FoundPair> renewed_;             // pairs that were found in this renewal
  std::vector<ManifoldPair> before_;           // pairs of renewed bodies that were there before
  std::vector<std::uint64_t> fixed_;           // if some are kinematic: slot << 32 | pair with a fixed side, ascending
  bool fixed_known_ = false;                   // fixed_ is that of pairs_
  bool any_kinematic_ = false;                 // some fixed sides are kinematic
  std::vector<std::uint64_t> crowded_;  // of bodies that meet several fixed pieces: slot << 32 | place in `active`
  std::vector<std::uint32_t> turned_;   // pairs of one of them
  std::vector<std::uint32_t> turning_;  // pairs whose kinematic side turns fast
  std::vector<StripBlocks> strips_;
  std::vector<std::uint32_t> known_lane_;  // by pair: its lane if SteadyLanes knows it, else kNone
  std::vector<std::uint8_t> special_;      // by strip: some of its bodies are no plain discs
  std::vector<std::uint8_t> stale_;        // by strip: its blocks have other pairs
  Column<std::uint8_t> kind_{s_.memory};   // by slot
  Column<float> rotor_{s_.memory};         // by slot, records
  Column<float> inner_{s_.memory};         // by slot: m, the inner radius in this step
  Column<std::uint32_t> used_{s_.memory};  // by slot, within a part of the step: what it counts or marks
  std::vector<std::uint8_t> stood_;        // by slot: whether the body hung together with fixed ground
  std::vector<std::uint32_t> shaped_;      // slots of bodies that are not discs
  std::vector<std::uint32_t> long_;  // of those: long shapes and bodies of several parts, where steps select pairs
  Totals totals_;
  Looks looks_;                   // of the last refresh
  std::uint64_t new_pairs_ = 0;   // since then
  float g_ = 0;                   // m/s^2, in this step
  float step_ = 0, gravity_ = 0;  // of CollectSettings
  bool any_filter_ = false;
  bool wall_special_ = false;  // the walls run or resist rolling
  bool both_ = false;          // old_pairs_ has the pairs of the last step
  bool collecting_ = false;    // pairs_ is not complete yet
  bool laid_ = false;          // impulses are in the blocks, not in the pairs
  bool cold_ = false;
  bool weighs_ = false;       // there was gravity when footings were found
  bool attempted_ = false;    // pairs were looked at, and not laid out yet
  bool stood_known_ = false;  // stood_ is that of the last step, and of the present slots and pairs
};

}  // namespace psim
