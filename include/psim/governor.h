// Keeping a frame's deadline by doing less: which detail a step gets is decided from counted work and from
// what a unit of work costs on this machine, measured once at the start. No clock is read inside a step, so
// a run that was cut replays bit for bit from its details.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "psim/api.h"

namespace psim {

/// A model holds the costs of work on one machine with one number of threads. World::measure_costs makes one; a default
/// model holds the costs of the machine that the engine was calibrated on (docs/governor.md).
class PSIM_API CostModel {
 public:
  static constexpr std::size_t kNumbers = 37;  ///< how many numbers make a model
  /// A model as numbers, ns each, in an order of the engine's own.
  using Numbers = std::array<double, kNumbers>;

  /// The costs of the machine that the engine was calibrated on.
  CostModel();
  /// A model from numbers that numbers() gave out, by the same version of psim.
  explicit CostModel(const Numbers& numbers) : numbers_(numbers) {}
  /// The model in numbers, to be kept and given back. What each of them means may change from version to version.
  Numbers numbers() const { return numbers_; }

 private:
  Numbers numbers_;
};

/// How a frame's budget is kept.
struct GovernorDesc {
  bool on = false;                 ///< off: every step is done in full
  double budget_ms = 1000.0 / 60;  ///< of a frame; three quarters of it may be predicted
  CostModel costs = {};            ///< turns counted work into time
};

/// How much of a step was or is to be done in a frame.
struct StepDetail {
  static constexpr std::uint8_t kMostSubsteps = 64;   ///< of `substeps`
  static constexpr std::uint8_t kMostFrames = 8;      ///< of `frames` and `horizon`, which are at least 1
  static constexpr std::uint8_t kMostSweeps = 15;     ///< of `sweeps`
  static constexpr std::uint8_t kMostFluidParts = 3;  ///< of `fluid_parts`

  std::uint8_t substeps = 0;  ///< 0: as the world's description has it
  /// Whether the step ends in this frame. Else time stands still: the work ahead of the substeps is spread
  /// over several frames.
  bool solves = true;
  std::uint8_t frames = 1;   ///< that the step makes up for: it is so many times as long
  std::uint8_t horizon = 1;  ///< frames that lists made in it serve: no less than `frames`
  std::uint32_t pieces = 0;  ///< of the work ahead, done in a frame in which time stands still
  /// All was ready, but bodies woke that would have been met: time stands still, lists are made anew.
  bool wakes = false;
  std::uint8_t sweeps = 0;       ///< over impacts in a substep, at most; 0: as many as it takes
  std::uint8_t fluid_parts = 0;  ///< in which fluids move, at most; 0: as many as it takes
  /// Whether time stands still in the frame.
  bool waits() const { return !solves; }
  /// All alike.
  friend bool operator==(const StepDetail&, const StepDetail&) = default;
};

}  // namespace psim
