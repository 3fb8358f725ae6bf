// Forces and torques of one step: those that the host applies, and those of wind and water (media.h). The force is part
// of the accelerations of its body (BodyStore::acc), the torque kicks its rim speed. O(bodies that are pushed).
//
// In and out: columns of bodies, whose slots are known.
#pragma once

#include <cstddef>
#include <vector>

#include "base/lattice.h"
#include "bodies/population.h"
#include "solver/media.h"

namespace psim {

/// What pushes bodies in a step of dt seconds, which may make up for several frames: each force of the host was applied
/// for one of them. No force makes a body faster in a step than bodies can be.
class ForcesOfStep {
 public:
  /// `room` holds the pushes as long as this lives.
  ForcesOfStep(const Population& population, const Lattice& lattice, double frame, double dt, const Media& media,
               std::vector<Push>& room);

  bool any() const { return !pushes_.empty(); }
  /// Adds the accelerations to BodyStore::acc, or puts back there what gravity alone gives.
  void add(BodyStore& bodies) const;
  void put_back(BodyStore& bodies, Vec2 gravity) const;
  /// Adds to velocities what the accelerations give in h seconds: for integrators that do not read them.
  void kick(BodyStore& bodies, double h) const;
  /// Adds to the rim speeds what the torques give in h seconds: of bodies that take substeps, or of all others.
  void spin(BodyStore& bodies, double h, bool linked) const;

 private:
  std::vector<Push>& pushes_;  // each body once for the host, and once for the media
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
