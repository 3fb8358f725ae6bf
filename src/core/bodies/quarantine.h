// Bodies that left the bounds, are too fast, or whose numbers are broken. All of this is rare: the integrator tells
// whether there is any such body, and only then every body is looked at. O(bodies).
//
// In: the population after the integrator. Out: bodies are slowed, put back, frozen or removed. How a body is frozen
// or removed is up to the world, since joints, sleepers and events take part; it gives a function for it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/tasks.h"
#include "bodies/population.h"
#include "kernel_table.h"

namespace psim {

class Quarantine {
 public:
  /// Freezes a body that moves. It keeps the state.
  using Freeze = std::function<void(const BodyState& last)>;
  using Remove = std::function<void(std::uint32_t id)>;

  /// Freezes the bodies in `doubtful` that still move. Returns how many.
  std::uint32_t freeze_doubtful(const Population& population, const Freeze& freeze);
  /// Slows bodies that are too fast for a step of dt seconds, and freezes those whose numbers are broken where the
  /// lists saw them last. Returns how many were frozen.
  std::uint32_t settle(Population& population, const Lattice& lattice, double dt, const Freeze& freeze);
  /// Open worlds: removes the bodies whose centre left the bounds, and counts them in `escaped`.
  void remove_escaped(const Population& population, const Bounds& bounds, const Remove& remove);
  /// Walled worlds: puts bodies back that came out behind a wall.
  static void bring_back(Population& population, const Lattice& lattice, const WorldDesc& desc);
  /// Whether all centres of the blocks lie within the walls, to a lattice step.
  static bool walls_hold(const BodyStore& bodies, const Walls& walls, const kernels::KernelTable& kernels,
                         BlockRange blocks);

  std::vector<BodyId> doubtful;  ///< the host gave them NaN or infinity: the next step freezes them
  std::uint64_t escaped = 0;     ///< bodies that left an open world since it was made
};

}  // namespace psim
