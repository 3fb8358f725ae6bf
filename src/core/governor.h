// Decides how much of a step is done, from counts alone (psim/governor.h).
#pragma once

#include <cstdint>

#include "psim/governor.h"

namespace psim {

/// Work in a step, counted.
struct WorkCounts {
  std::uint64_t bodies = 0;      ///< in the columns
  std::uint64_t solved = 0;      ///< that the solver has
  std::uint64_t candidates = 0;  ///< that a step selects from
  std::uint64_t contacts = 0;    ///< of discs
  std::uint64_t manifolds = 0;
  std::uint64_t joints = 0;      ///< joints x sweeps
  bool builds = false;           ///< lists are made
  bool lays_out = false;         ///< contacts are
  bool bounces = false;          ///< with sweeps over impacts
};

class Governor {
 public:
  void set(const GovernorDesc& desc) { desc_ = desc; }
  bool on() const { return desc_.on; }

  /// ns of everything but the solver's substeps, and of one substep.
  double fixed_ns(const WorkCounts& work) const;
  double substep_ns(const WorkCounts& work) const;

  /// The parts of a step by frame: as few frames as keep the budget, one to three.
  struct Spread {
    std::uint8_t frames = 1;
    std::uint8_t parts[3] = {StepDetail::kAll, 0, 0};
  };
  Spread spread(const WorkCounts& work) const;
  /// How many substeps fit, `least` to `most`.
  int substeps(const WorkCounts& work, int least, int most) const;

 private:
  /// Of the budget: what is left is for what the model does not know.
  static constexpr double kShare = 0.8;
  double room_ns() const { return kShare * desc_.budget_ms * 1e6; }
  double lists_ns(const WorkCounts& work) const;
  double contacts_ns(const WorkCounts& work) const;
  double geometry_ns(const WorkCounts& work) const;

  GovernorDesc desc_;
};

}  // namespace psim
