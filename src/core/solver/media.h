// Wind and water: what the media that the host describes do to the bodies in them (WindField, BuoyancyField). The force
// of a step is that at the middle of the way that a body goes in it, as leapfrog has it, so that what floats keeps its
// energy. O(corners of bodies that move).
//
// In: columns of bodies, shapes. Out: accelerations, ordered by slot.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "psim/desc.h"

namespace psim {

/// What pushes a body in a step.
struct Push {
  std::uint32_t slot = 0;
  Vec2 acceleration;            ///< m/s^2
  double rim_acceleration = 0;  ///< m/s^2
};

/// Whether some field is a medium.
bool any_medium(const std::vector<Field>& fields);

class Media {
 public:
  /// Finds what the media of a world do in a step of dt seconds.
  void find(const WorldDesc& desc, const Lattice& lattice, const BodyStore& bodies, WorkerPool& pool, double dt);
  /// Calls each(push) for every body that is pushed.
  template <class Each>
  void each(const Each& each) const {
    for (const std::vector<Push>& some : found_) {
      for (const Push& push : some) each(push);
    }
  }
  void clear() {
    for (std::vector<Push>& some : found_) some.clear();
  }
  std::size_t bytes() const;
  void release() { give_back(found_); }

 private:
  std::vector<std::vector<Push>> found_;  // by job
};

}  // namespace psim
