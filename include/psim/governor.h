// Keeping a frame's deadline by doing less: which detail a step gets is decided from counted work and from
// what a unit of work costs on this machine, measured once at the start. No clock is read inside a step, so
// a run that was cut replays bit for bit from its details.
#pragma once

#include <cstdint>

namespace psim {

/// What a unit of work costs, ns, on one machine with one number of threads: World::measure_costs.
struct CostModel {          // the defaults: least squares over 14 scenes (docs/governor.md)
  double step = 3000;       ///< a step, whatever is in it
  double check = 5;         ///< a body: do its lists serve, integrate, sleep
  double build = 38;        ///< a body, when lists are made
  double select = 3.5;      ///< a candidate pair, when a step selects from them
  double colour = 19;       ///< a contact of discs, when contacts are laid out
  double narrow = 0.5;      ///< a contact of discs: its normal
  double look = 134;        ///< a manifold: its normal, gaps, columns, lane
  double body_pass = 1.2;   ///< a body that the solver has, a substep
  double pass = 3.5;        ///< a contact of discs, a substep
  double bounce_pass = 17;  ///< the same with restitution: sweeps over impacts
  double shape_pass = 8;    ///< a manifold, a substep
  double joint_pass = 62;   ///< a joint, a substep
};

/// How a frame's budget is kept.
struct GovernorDesc {
  bool on = false;                 ///< off: every step is done in full
  double budget_ms = 1000.0 / 60;  ///< of a frame; four fifths of it may be predicted
  CostModel costs;                 ///< by which work becomes time
};

/// How much of a step was or is to be done.
struct StepDetail {
  static constexpr std::uint8_t kLists = 1;     ///< neighbour lists
  static constexpr std::uint8_t kContacts = 2;  ///< contacts and their colours
  static constexpr std::uint8_t kSolve = 4;     ///< the rest: bodies move
  static constexpr std::uint8_t kAll = 7;       ///< all three

  std::uint8_t substeps = 0;  ///< 0: as the world's description has it
  /// What is done in this frame. Without kSolve time stands still: the work of one long step is spread over
  /// several frames.
  std::uint8_t parts = kAll;
  std::uint8_t frames = 1;  ///< that the step makes up for: it is so many times as long
  /// Whether time stands still in the frame.
  bool waits() const { return (parts & kSolve) == 0; }
  /// All three alike.
  friend bool operator==(const StepDetail&, const StepDetail&) = default;
};

}  // namespace psim
