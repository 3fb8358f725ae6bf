// What observers read: the owners of a world, and where its bodies are.
#pragma once

#include "base/worker_pool.h"
#include "bodies/population.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"
#include "sleep/sleep.h"

namespace psim {

struct Observed {
  const WorldDesc& desc;
  const Lattice& lattice;
  const Walls& walls;
  const Population& population;
  const Sleep& sleep;
  const PairTable& table;
  const Contacts& contacts;
  WorkerPool& pool;
  const BodyStore& bodies = population.bodies;
  const StaticShapes& statics = population.statics;

  /// m: how far apart the copies of a body lie in a periodic world; else 0.
  Vec2 period() const {
    if (desc.boundary != Boundary::periodic) return {};
    return {desc.bounds.xmax - desc.bounds.xmin, desc.bounds.ymax - desc.bounds.ymin};
  }
  bool any_kinematic() const { return !population.kinematics.empty(); }
  BodyState state_of(std::uint32_t id) const { return sleep.state_of(population, lattice, id); }
  LatticePoint place(std::size_t slot) const { return bodies.point(slot); }
  /// m, from the centre of the lattice.
  Vec2 from_centre(const LatticePoint& p) const { return lattice.from_centre(p); }
  Vec2 to_world(const LatticePoint& p) const { return lattice.to_world(p); }
};

}  // namespace psim
