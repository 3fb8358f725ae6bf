// The neighbour lists of the moving bodies, and all that belongs to them: the broad phase that makes them, the renewal
// that mends them body by body, and the numbers that say how they were made.
//
//   persistent          broad phase --------------> table            contacts last as long as the lists
//   selected each step  broad phase -> candidates -> select -> table  contacts are laid out in every step
//
// `table` is what contacts are made from; `old_table` is the one before, by which the impulses of the last step lie
// until the new contacts have taken them over (step/step_context.h).
#pragma once

#include <cstdint>
#include <vector>

#include "lists/broad_phase.h"
#include "lists/impact_speeds.h"
#include "lists/pair_table.h"
#include "lists/renewal.h"
#include "psim/desc.h"

namespace psim {

/// How lists are kept (docs/step.md, "Two ways of keeping lists").
enum class ListMode : std::uint8_t {
  persistent,          ///< bodies rest or creep: the candidates are the contacts while the lists last
  selected_each_step,  ///< bodies fly: each step selects the pairs that can meet in it
  one_step,            ///< the same, and the lists serve one step alone
};

/// What the lists must know of the world.
struct ListSettings {
  const WorldDesc* desc = nullptr;
  float least_radius = 0;    ///< m, of all moving bodies
  bool uneven = false;       ///< masses differ: a heavy body may throw a light one
  bool restitution = false;  ///< impacts may speed bodies up
  bool mixed_radii = false;
  bool shapes = false;      ///< some bodies are no discs
  bool link_all = false;    ///< every body takes substeps (fields)
  bool governed = false;    ///< a governor counts how many bodies each is looked at with
  bool makes_room = false;  ///< more candidates than in the last lists are to be expected
  std::uint64_t step = 0;   ///< number of this step
};

/// How the present lists were made.
struct ListNumbers {
  double frames = 0;             ///< that lists with a selection are made for; 0: one step, looking ahead
  double span = 1;               ///< frames of a step that they were made for
  double selected_span = 1;      ///< frames of the last step that pairs were selected for
  double reach = 0;              ///< m: a typical distance up to which two bodies are candidates
  double skin = 1;               ///< WorldDesc::skin at the time
  double speed = 0;              ///< m/s: root mean square of a sample of bodies about its mean
  double crowding = 0.1;         ///< 0.1 to 1: how likely one impact leads to another within a step
  double impact_rate = 0;        ///< 1/s: impacts of a body, if all were in flight
  std::uint64_t candidates = 0;  ///< how many there were in a saved state, while they are not there again
};

struct NeighbourLists {
  explicit NeighbourLists(const Surroundings& s) : surroundings(s) {}

  /// Whether each step selects its pairs from the candidates.
  bool selects() const { return mode != ListMode::persistent; }
  /// The table that the broad phase writes.
  PairTable& found() { return selects() ? candidates : table; }
  const PairTable& found() const { return selects() ? candidates : table; }

  /// Whether the lists can serve dt seconds more. O(bodies).
  bool serve(double dt) { return broad.lists_serve(static_cast<float>((selects() ? 1.0 : kMarginFrames) * dt)); }
  /// Decides how new lists for steps of dt seconds are made: for how long and with which margins, from a sample of the
  /// bodies' speeds and radii, and the density of the last lists. The broad phase then counts cells, moves the bodies in
  /// their order and searches.
  void measure(const ListSettings& world, double dt);
  /// Moves [begin, end) of the bodies' moves to cell order. True with the last: then they lie in the new order, and
  /// persistent lists have begun a new table.
  bool move(std::size_t begin, std::size_t end);
  /// Selects from the candidates of strips [begin, end) the pairs that can meet within dt seconds at their present
  /// relative velocity u, into a new table: gap < |u| time + slack. Sets bodies.linked. O(candidates).
  /// No slack is more than what speeds all over the world ask for; it is less where all move alike: in a strip
  /// (docs/decisions/013-slack-by-strip.md) or, where masses differ, near a body
  /// (docs/decisions/032-slack-by-segment.md).
  void select(const ListSettings& world, double dt, std::size_t begin, std::size_t end);
  /// Packs the selected pairs of strips [begin, end) side by side, after all strips were selected.
  void pack(std::size_t begin, std::size_t end);
  /// Whether lists can be made anew for a few bodies alone.
  bool may_renew() const {
    const std::uint32_t bodies = surroundings.bodies.count;
    return !selects() && bodies >= BroadPhase::kSmallWorld && bodies == table.body_count;
  }
  std::size_t bytes() const { return renewal.bytes() + speeds.bytes() + thrown.bytes() + broad.common().bytes(); }
  CommonMotion::Fixed fixed_of(const WorldDesc& desc) const;
  double slack(const ListSettings& world, double dt, std::size_t strip) const;

  const Surroundings surroundings;
  BroadPhase broad{surroundings};
  ListRenewal renewal{surroundings, broad};
  StripSpeeds speeds{surroundings};    ///< where masses are alike
  SegmentSpeeds thrown{surroundings};  ///< where they differ
  Column<std::uint32_t> picked_owner{surroundings.memory}, picked_other{surroundings.memory};  ///< not yet packed
  PairTable table{surroundings.memory}, old_table{surroundings.memory}, candidates{surroundings.memory};
  ListMode mode = ListMode::persistent;
  bool stale = true;  ///< new lists must be made before the next step
  ListNumbers made;
};

}  // namespace psim
