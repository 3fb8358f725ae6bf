// What a scene needs, decided from its traits whenever they change: which stages run and which
// variants of the contact kernels. What is not in the plan owns no memory and costs no branch.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/traits.h"
#include "contacts/contact_model.h"
#include "psim/desc.h"
#include "psim/integrator.h"
#include "psim/report.h"

namespace psim {

struct Plan {
  bool forces = false;                         ///< accelerations differ from body to body
  bool fields = false;                         ///< and with place or speed: every body takes substeps
  bool scales = false;                         ///< and gravity does not act on all alike
  Integrator integrator = Integrator::verlet;  ///< verlet where there are no fields
  bool friction = false;
  bool restitution = false;
  bool masses = false;     ///< masses of discs differ
  bool uneven = false;     ///< masses of bodies that meet may differ
  bool loads = false;      ///< masses differ so much that some bodies may carry much heavier ones
  bool radii = false;      ///< radii differ
  bool materials = false;  ///< of discs: mass, friction or restitution unequal
  bool rotation = false;
  bool manifolds = false;  ///< moving bodies other than discs: manifolds
  bool filters = false;    ///< not everybody collides with everybody
  bool joints = false;
  bool turns = false;       ///< points turn with their bodies within a frame: there are shapes or joints
  bool continuous = false;  ///< fast bodies are stopped at what they would jump over
  bool bullets = false;     ///< also against other moving bodies
  bool surfaces = false;    ///< some surfaces run, resist rolling, are solid from one side or ask the host
  bool restraints = false;  ///< damping and locks of single bodies
  bool sleep = false;
  bool events = false;
  bool publish = false;
  ContactModel model;

  friend bool operator==(const Plan&, const Plan&) = default;
};

/// The traits that follow from the description of a world alone.
void take_traits(const WorldDesc& desc, Traits& traits);

Plan make_plan(const Traits& traits);

/// The plan as a table for people, with the reason of every entry; bytes are left 0.
std::vector<PlanEntry> explain(const Plan& plan, const Traits& traits);

}  // namespace psim
