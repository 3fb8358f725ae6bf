// What observers read: the owners of a world, and where its bodies are.
#pragma once

#include <cmath>
#include <utility>

#include "base/worker_pool.h"
#include "bodies/population.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"
#include "sleep/sleep.h"

namespace psim {

inline double wide(float v) { return static_cast<double>(v); }

/// Whether a contact touched at the end of the step: an impulse of -0 marks an open one.
inline bool closed(float impulse) { return !std::signbit(impulse); }

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
  /// Whether the host is told that two bodies touch. It is not told of two kinematic ones, or of one that touches
  /// fixed geometry (kNoSlot).
  bool tells_of(std::uint32_t a, std::uint32_t b = kNoSlot) const {
    const auto dynamic = [&](std::uint32_t id) {
      return id != kNoSlot && bodies.properties(id).type() == BodyType::dynamic_body;
    };
    return !any_kinematic() || dynamic(a) || dynamic(b);
  }
  /// The handle of a body, or of a wall (kNoSlot).
  BodyId handle(std::uint32_t id) const { return id == kNoSlot ? kNoBody : BodyId{id, bodies.info[id].generation}; }
  BodyState state_of(std::uint32_t id) const { return sleep.state_of(population, lattice, id); }
  /// The centre and the angle, rad, of a body that moves or sleeps.
  std::pair<LatticePoint, double> stand(std::uint32_t id) const {
    const BodyInfo& info = bodies.info[id];
    if (info.place != Place::asleep) return {bodies.point(info.slot), bodies.angle_of(info.slot)};
    const Sleeper& sleeper = sleep.sleepers.list[info.slot];
    return {sleeper.at, sleeper.angle};
  }
};

}  // namespace psim
