// Where fluids come from and where they go: emitters let them out of segments, drains take them away.
//
// An emitter with n columns lets out a row of n particles each time that the fluid has moved n spacing^2 / length, so that
// a particle stands for spacing^2 of it, whatever the length. The middle of a row leaves the segment when half of the row
// has: the number of particles differs from what has flowed by half a row at most.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "psim/desc.h"
#include "psim/fluid.h"

namespace psim {

struct FluidEmitter {
  std::uint32_t id = 0;
  EmitterDesc desc;
  double age = 0;             ///< s since it was added
  double rows = 0.5;          ///< that have flowed, less those that were let out
  std::uint64_t emitted = 0;  ///< particles
};

struct FluidDrain {
  std::uint32_t id = 0;
  Bounds region;
};

struct FluidTaps {
  std::vector<FluidEmitter> emitters;  // by id
  std::vector<FluidDrain> drains;      // by id
  std::uint32_t next_emitter = 0, next_drain = 0;
  std::uint64_t emitted = 0, drained = 0, withheld = 0;  // particles

  bool any() const { return !emitters.empty() || !drains.empty(); }
};

/// What flows out of an emitter in a step.
struct FluidOutflow {
  std::uint32_t columns = 1;
  double pitch = 0;  ///< m from row to row
  double rows = 0;   ///< that are let out, a whole number
  double left = 0;   ///< rows that have flowed, less those that were let out, after the step
  double late = 0;   ///< s from when the emitter closed to the end of the step
};
FluidOutflow outflow(const FluidEmitter& emitter, double spacing, double dt);

/// One line of what is wrong with an emitter, or empty.
std::string check_emitter(const EmitterDesc& desc, std::size_t fluids, const Bounds& bounds);
/// One line of what is wrong with the region of a drain, or empty.
std::string check_drain(const Bounds& region);

}  // namespace psim
