// What a step does after its contacts are known: normals and gaps, substeps, and the move to the end of the frame.
#pragma once

#include "step/step_context.h"

namespace psim {

/// Colours and blocks of the manifolds that were found, for a step of dt seconds. O(touching pairs).
void lay_out_manifolds(StepContext& c, double dt);
/// The narrow phase of all contacts: lay_out_manifolds(), then normals and gaps of the contacts of discs. O(contacts).
void narrow_phase(StepContext& c, double dt);

/// What move_bodies() saw on its way.
struct Moved {
  bool sound = true;   ///< no body has a bad number or excessive speed
  bool inside = true;  ///< nobody is beyond the walls or the bounds
};
/// Substeps for those who may touch something; the closed form of the frame for free bodies. O(bodies). Almost all that
/// takes memory is done before Dynamics::moving becomes true; std::bad_alloc until then leaves all bodies as they were.
Moved move_bodies(StepContext& c, double dt, StepReport& report);

}  // namespace psim
