// What a world tells about itself: per step, and about the plan it runs by.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "psim/governor.h"

namespace psim {

/// The stages of a step, in order. The same word names a stage in its file, timer, trace, bench
/// and test.
enum class Stage : std::uint8_t {
  forces,        ///< wells and drag
  broad_phase,   ///< neighbour lists
  narrow_phase,  ///< normals and gaps
  colouring,     ///< contacts in groups that share no body
  solver,        ///< contacts and joints
  integrate,     ///< bodies move
  fluid,         ///< particles of fluids move
  sleep,         ///< who falls asleep
  publish,       ///< snapshots and events
};
/// How many stages there are.
inline constexpr std::size_t kStageCount = 9;
/// The words for Stage, by its number.
inline constexpr std::array<std::string_view, kStageCount> kStageNames = {
    "forces", "broad_phase", "narrow_phase", "colouring", "solver", "integrate", "fluid", "sleep", "publish"};

/// A step can leave out these stages and parts of stages. The number of each is its bit in StepReport::skipped.
enum class Skip : std::uint8_t {
  forces,        ///< wells, drag and gravity scales
  broad_phase,   ///< the search for neighbours
  narrow_phase,  ///< normals and gaps of contacts
  colouring,     ///< colours and lanes of contacts
  solver,        ///< the substeps
  restitution,   ///< impacts with restitution
  masses,        ///< unequal masses
  friction,      ///< friction
  rotation,      ///< rotation of bodies
  publish,       ///< snapshots for a renderer
  heavy_loads,   ///< stiffer contacts under heavy loads
  events,        ///< events for the host
  manifolds,     ///< contacts of shapes
  joints,        ///< joints
  filters,       ///< pairs that must not collide
  continuous,    ///< motion of fast bodies
  fluid,         ///< fluids: there are none, or they lie still
};
/// The words for Skip, by its number.
inline constexpr std::array<std::string_view, 17> kSkipNames = {"forces",
                                                                "broad_phase",
                                                                "narrow_phase",
                                                                "colouring",
                                                                "solver",
                                                                "solver.restitution",
                                                                "solver.masses",
                                                                "solver.friction",
                                                                "rotation",
                                                                "publish",
                                                                "solver.heavy_loads",
                                                                "events",
                                                                "manifolds",
                                                                "joints",
                                                                "filters",
                                                                "continuous",
                                                                "fluid"};

/// What one step did. Values, never exceptions: bad data in a running world is quarantined and
/// counted here.
struct StepReport {
  std::array<double, kStageCount> stage_ms{};  ///< wall time a stage
  double total_ms = 0;                         ///< wall time of the step
  std::uint64_t pairs = 0;                     ///< candidate pairs in the lists, static shapes among them
  std::uint64_t contacts = 0;                  ///< points that touch (impulse > 0 or overlap): at most two a pair
  std::uint32_t colours = 0;                   ///< most colours that any group of contacts needed
  std::uint64_t awake = 0;                     ///< dynamic and kinematic bodies that are awake after it
  std::uint64_t asleep = 0;         ///< dynamic bodies that sleep after it: all others of World::dynamic_count
  std::uint64_t pairs_reused = 0;   ///< of the pairs, those whose contacts lay as they were
  bool rebuilt = false;             ///< neighbour lists were rebuilt in this step
  std::uint32_t renewed = 0;        ///< bodies whose lists alone were made anew
  std::uint32_t skipped = 0;        ///< a bit for each of kSkipNames that had nothing to do
  std::uint32_t fast = 0;           ///< bodies so fast for their size, or so deep, that their way was looked at
  std::uint32_t stopped = 0;        ///< of those, bodies that struck something on their way
  std::uint32_t escaped = 0;        ///< bodies that left an open world in this step
  std::uint32_t quarantined = 0;    ///< bodies frozen in this step because of NaN, infinity or excess
  std::uint64_t arena_growths = 0;  ///< allocations that this step had to make (0 once warm)
  StepDetail detail;                ///< how much of it was done
  double predicted_ms = 0;          ///< by the governor's cost model; 0 without a governor
  /// Why nothing was done: there was no room for "pairs", "contacts" or, of a recorder, the "recording", and the world is
  /// as before; or null. "motion": bodies had begun to move, and no later call does anything. "events", "snapshot": the
  /// step was done, but there was no room for what it tells. After lost events the next step tells of all that touch then,
  /// as if they began to. "sleep", "escape", "breaks": the step was done, but bodies that rest stay awake, bodies that left
  /// an open world stay in it, or joints that bore too much hold, up to a later step.
  const char* no_room_for = nullptr;
  double virial = 0;  ///< N s m: sum over contacts of normal impulse x centre distance, see docs/queries-events.md
  std::uint64_t touching = 0;  ///< of the pairs, those with such contacts
};

/// Sums over every body, computed when asked for (not part of a step), in double precision and in
/// id order.
struct Diagnostics {
  double kinetic = 0;           ///< J, rotation included
  double potential = 0;         ///< J: uniform gravity from y = 0 (x = 0), and wells
  double momentum_x = 0;        ///< kg m/s
  double momentum_y = 0;        ///< kg m/s
  double angular_momentum = 0;  ///< kg m^2/s about the origin
  double max_penetration = 0;   ///< metres: the deepest overlap as bodies stand now; 0 before the first step
};

/// One stage of the plan: whether this scene needs it and why.
struct PlanEntry {
  std::string stage;    ///< e.g. "narrow_phase", "solver.friction"
  bool needed = false;  ///< whether steps run it
  std::string reason;   ///< e.g. "no body and no wall has friction"
  /// Memory of arrays that are there for this alone. What every world with moving bodies has (bodies, lists,
  /// contacts) is in no entry.
  std::size_t bytes = 0;
};

/// Work since the world was made: what vectors did, their empty lanes included, and what was done one at a
/// time where the ISA has lanes: contacts' places on fixed shapes, pairs of hulls that no kernel takes or that
/// were too few for one, contacts in columns. All of it on Isa::scalar.
struct LaneCounts {
  std::uint64_t vector = 0;  ///< elements done in lanes
  std::uint64_t scalar = 0;  ///< elements done one at a time
};

/// How full the blocks of some kernels were, summed over the steps that were looked at (World::count_lane_use).
/// A block counts once a step, however often the kernels went over it.
struct LaneUse {
  std::string kernels;      ///< what they work on, e.g. "contacts"
  std::uint64_t lanes = 0;  ///< of the blocks
  std::uint64_t used = 0;   ///< of those, with something in them
};

/// One span of a stage on one thread, for traces. Times are nanoseconds from the first call of
/// World::start_trace.
struct TraceEvent {
  const char* name = "";      ///< of the stage
  int thread = 0;             ///< 0: the one that steps
  std::int64_t begin_ns = 0;  ///< nanoseconds
  std::int64_t end_ns = 0;    ///< nanoseconds
};

}  // namespace psim
