// Forces and torques that the host applies for one step. The force is part of the accelerations of its body
// (BodyStore::acc), the torque kicks its rim speed. O(bodies that are pushed).
//
// In and out: columns of bodies, whose slots are known.
#pragma once

#include <cstddef>

#include "base/lattice.h"
#include "bodies/population.h"

namespace psim {

/// What the applied forces do in a step of dt seconds, which may make up for several frames: each force was applied for
/// one of them. No force makes a body faster in a step than bodies can be.
class ForcesOfStep {
 public:
  ForcesOfStep(const Population& population, const Lattice& lattice, double frame, double dt);

  bool any() const { return !population_.applied.empty(); }
  /// Adds the accelerations to BodyStore::acc, or puts back there what gravity alone gives.
  void add(BodyStore& bodies) const;
  void put_back(BodyStore& bodies, Vec2 gravity) const;
  /// Adds to velocities what the accelerations give in h seconds: for integrators that do not read them.
  void kick(BodyStore& bodies, double h) const;
  /// Adds to the rim speeds what the torques give in h seconds: of bodies that take substeps, or of all others.
  void spin(BodyStore& bodies, double h, bool linked) const;
  /// m/s^2
  Vec2 acceleration_of(const AppliedForce& force) const;
  double rim_acceleration_of(const AppliedForce& force) const;

 private:
  const Population& population_;
  double frame_, dt_, most_;
};

/// While it lives, bodies that are pushed have the velocities that they would have after the step: lists are made for
/// these. Slots may change meanwhile.
class LentSpeeds {
 public:
  LentSpeeds(Population& population, const Lattice& lattice, double frame, double dt);
  ~LentSpeeds();
  LentSpeeds(const LentSpeeds&) = delete;
  LentSpeeds& operator=(const LentSpeeds&) = delete;

 private:
  Population& population_;
};

}  // namespace psim
