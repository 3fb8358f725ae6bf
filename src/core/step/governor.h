// Decides how much of a step is done, from counts alone (psim/governor.h).
#pragma once

#include <cstdint>
#include <functional>

#include "fluid/fluids.h"
#include "step/cost_table.h"
#include "step/work_counts.h"

namespace psim {

/// Predicted ns of what comes after the parts of the step table but for the substeps, and of one substep: linear in the
/// counts, with a few factors for how work of one kind differs. docs/governor.md has where the numbers come from.
double rest_ns(const UnitCosts& costs, const WorkCounts& work);
double substep_ns(const UnitCosts& costs, const WorkCounts& work);
/// The same of a part of the fluids' step.
double fluid_part_ns(const UnitCosts& costs, std::size_t particles, const FluidWork& work);

struct StepContext;
struct StepReport;

class Governor {
 public:
  /// Sweeps over impacts in a substep that has no time for as many as it takes.
  static constexpr int kFewSweeps = 1;

  /// Whether no number is broken.
  static bool sound(const GovernorDesc& desc);
  void set(const GovernorDesc& desc) { desc_ = desc; }
  bool on() const { return desc_.on; }
  UnitCosts costs() const { return unit_costs(desc_.costs); }

  /// Does of a step's work what fits into a frame of dt seconds, and chooses the detail: whether the rest of the step
  /// fits, too, with how many substeps, and how many frames it makes up for. The lists of a world's first frame belong
  /// to making ready (World::prepare).
  void spend_frame(StepContext& c, double dt, StepReport& report) const;
  /// ns of a frame that fluids may take beside bodies that take so many: what these leave, but a half at least and seven
  /// eighths at most.
  double fluids_room_ns(double of_bodies) const;
  /// Chooses in how many parts fluids move, and returns the predicted ns, which may be more than there is room for.
  double govern_fluids(const StepContext& c, double dt, StepDetail& detail) const;
  /// Whether new lists fit beside what is predicted already; if not, the substeps will not be done either, and are
  /// taken out of the prediction.
  bool fits_again(const StepContext& c, StepReport& report) const;

  /// ns that may be predicted for a frame.
  double room_ns() const { return kShare * desc_.budget_ms * 1e6; }

  /// How many times as many candidates lists for more frames have as those that were counted, and how many times as
  /// long a step contacts are selected for: so many more are there, unless most candidates are contacts already.
  struct Growth {
    double candidates = 1, time = 1;
  };
  /// How many frames a step's lists should serve, if its work is to be spread; 1: it fits into one. growth(frames).
  int horizon(const WorkCounts& work, int most_substeps, const std::function<Growth(int)>& growth = {}) const;

  struct Choice {
    bool solves = false;  ///< in this frame; else the next one is better
    int substeps = 0, frames = 1;
    int sweeps = 0;   ///< over impacts in a substep, at most; 0: as many as it takes
    double pace = 0;  ///< frames made up for in each that goes by; 0: not within the budget
  };
  /// For a frame that has `left` ns for what comes after the work ahead, the `elapsed`-th of its step. No
  /// substep is longer than a frame: time that they cannot make up for is lost. Sweeps over impacts are left out
  /// where less time is lost then. `fluids`: ns of each frame that are kept for these, and are not in `left`.
  Choice choose(const WorkCounts& work, double left, int elapsed, int horizon, int most_substeps,
                double fluids = 0) const;

 private:
  /// Of the budget: what is left is for what the model does not know.
  static constexpr double kShare = 0.75;

  GovernorDesc desc_;
};

}  // namespace psim
