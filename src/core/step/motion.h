// What a step does after its contacts are known: normals and gaps, substeps, and the move to the end of the frame.
#pragma once

#include <optional>

#include "step/step_context.h"

namespace psim {

/// Colours and blocks of the manifolds that were found, for a step of dt seconds. O(touching pairs).
void lay_out_manifolds(StepContext& c, double dt);
/// The same, and the normals and gaps of the contacts of discs. O(contacts).
void prepare_contacts(StepContext& c, double dt);

/// Fills the accelerations, joints and parameters for the substeps of a step of dt seconds; nothing, if nobody is near
/// anything: then the closed form of integrate() is all.
std::optional<SolverParams> prepare_substeps(StepContext& c, double dt, StepReport& report);
void run_substeps(StepContext& c, const SolverParams& params, StepReport& report);

/// Shapes and bullets that went far for their size are put back to where they met something.
void stop_fast_bodies(StepContext& c, StepReport& report);

/// What integrate() saw on its way.
struct Integrated {
  bool sound = true;   ///< no body has a bad number or excessive speed
  bool inside = true;  ///< nobody is beyond the walls or the bounds
};
/// Free bodies take the closed form of the frame; every body's offset folds into its lattice place. O(bodies).
Integrated integrate(StepContext& c, double dt, StepReport& report);

}  // namespace psim
