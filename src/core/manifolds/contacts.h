// All contacts of a world: those of discs, those of shapes, and how the solver numbers the bodies that have any.
// They are made from the neighbour lists and keep their impulses from step to step.
#pragma once

#include <array>

#include "contacts/contact_store.h"
#include "contacts/solver_bodies.h"
#include "lists/heavy_loads.h"
#include "manifolds/manifolds.h"
#include "manifolds/squeezed.h"
#include "manifolds/stacks.h"

namespace psim {

struct Contacts {
  Contacts(const Surroundings& s, const Material& wall) : surroundings(s), discs(s, wall, solved, loads) {}

  const Surroundings surroundings;
  SolverBodies solved{surroundings};           ///< the bodies that the solver works on
  HeavyLoads loads{surroundings.memory};       ///< bodies that carry much heavier ones
  ContactStore discs;                          ///< contacts of discs with discs and with fixed shapes
  Manifolds manifolds{surroundings};           ///< contacts of all other shapes
  Stacks stacks{surroundings, manifolds};      ///< bodies that stand on each other one by one
  Squeezed squeezed{discs, manifolds, loads};  ///< light bodies between heavy ones
  bool kept = false;                           ///< the contacts of this step are those of the last one
  bool impulses_valid = false;                 ///< the table's impulses belong to the present plan's contact model
  bool bare = false;                     ///< a state came back: contacts have impulses, but no geometry or colours
  std::array<float, 4> softness_laid{};  ///< compliance and rate in the lanes of manifolds, alone and under heavy loads
};

}  // namespace psim
