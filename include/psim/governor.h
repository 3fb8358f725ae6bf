// Keeping a frame's deadline by doing less: which detail a step gets is decided from counted work and from
// what a unit of work costs on this machine, measured once at the start. No clock is read inside a step, so
// a run that was cut replays bit for bit from its details.
#pragma once

#include <cstdint>

namespace psim {

/// What a unit of work costs, ns, on one machine with one number of threads: World::measure_costs.
struct CostModel {     // the defaults: docs/governor.md
  double step = 3000;  ///< a frame, whatever is in it
  // Ahead of the substeps.
  double check = 0.5;         ///< a body: do its lists serve
  double sort = 12.5;         ///< a body, when lists are made: to its cell
  double search = 3.5;        ///< a body: its candidates
  double test = 0.25;         ///< two bodies that are looked at for that
  double pair = 1.8;          ///< a candidate pair that is found
  double near = 2.5;          ///< a body: walls near it
  double near_fixed = 60;     ///< a body, where there are fixed shapes or sleepers
  double near_shape = 180;    ///< a fixed shape near a body
  double select = 2.2;        ///< a candidate pair, when a step selects from them
  double pack = 3.2;          ///< a pair that was selected, a body that the solver may leave out
  double group = 80;          ///< a manifold, when it is taken out of the lists of discs
  double load = 4;            ///< a contact of discs, where bodies carry much heavier ones
  double colour = 3.2;        ///< a contact of discs, when contacts are laid out: its colour
  double lay_out = 12;        ///< its lane
  double lay_out_rough = 18;  ///< the same with friction or restitution
  double keep = 40;           ///< a manifold that is kept as it is: its gaps
  double look = 180;          ///< a manifold that is looked at anew
  double stand = 14;          ///< a manifold: who stands on whom
  // Once a step.
  double column = 30;         ///< a manifold: its lane
  double narrow = 2.7;        ///< a contact of discs: its normal, its sums
  double load_body = 5;       ///< a body that the solver copies
  double move = 1.5;          ///< a body: integrate
  double stop = 15;           ///< a body, where shapes fly fast
  double sleep = 4;           ///< a body or a contact, each time that sleep looks at it
  double joint = 35;          ///< a joint
  double joint_sorted = 200;  ///< a joint whose bodies have new slots
  // A substep.
  double body_pass = 3.5;  ///< a body that the solver has
  double pass = 1.4;       ///< a lane of contacts of discs
  double touch = 3.9;      ///< a contact that presses
  double sweep = 2.4;      ///< a lane, in a sweep over impacts, where there is restitution
  double shape_pass = 15;  ///< a manifold
  double joint_pass = 44;  ///< a joint
  // Beside what is in them.
  double cell = 1;      ///< a cell of the grid, when lists are made
  double flight = 350;  ///< a fixed shape near the way of a fast shape
  double strip = 50;    ///< a strip, each time that its lists are gone through
};

/// How a frame's budget is kept.
struct GovernorDesc {
  bool on = false;                 ///< off: every step is done in full
  double budget_ms = 1000.0 / 60;  ///< of a frame; three quarters of it may be predicted
  CostModel costs;                 ///< by which work becomes time
};

/// How much of a step was or is to be done in a frame.
struct StepDetail {
  static constexpr std::uint8_t kMostSubsteps = 64;  ///< of `substeps`
  static constexpr std::uint8_t kMostFrames = 8;     ///< of `frames` and `horizon`, which are at least 1
  static constexpr std::uint8_t kMostSweeps = 15;    ///< of `sweeps`

  std::uint8_t substeps = 0;  ///< 0: as the world's description has it
  /// Whether the step ends in this frame. Else time stands still: the work ahead of the substeps is spread
  /// over several frames.
  bool solves = true;
  std::uint8_t frames = 1;  ///< that the step makes up for: it is so many times as long
  std::uint8_t horizon = 1;  ///< frames that lists made in it serve: no less than `frames`
  std::uint32_t pieces = 0;  ///< of the work ahead, done in a frame in which time stands still
  /// All was ready, but bodies woke that would have been met: time stands still, lists are made anew.
  bool wakes = false;
  std::uint8_t sweeps = 0;  ///< over impacts in a substep, at most; 0: as many as it takes
  /// Whether time stands still in the frame.
  bool waits() const { return !solves; }
  /// All alike.
  friend bool operator==(const StepDetail&, const StepDetail&) = default;
};

}  // namespace psim
