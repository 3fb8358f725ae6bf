// Accelerations that differ from body to body: wells, quadratic drag, gravity scales, kinematic
// bodies. Only worlds that have such things own a Forces; uniform gravity is part of the kick.
// O(bodies x fields) in double precision.
#pragma once

#include <vector>

#include "body_store.h"
#include "lattice.h"
#include "psim/desc.h"
#include "worker_pool.h"

namespace psim {

class Forces {
 public:
  Forces(std::vector<Field> fields, Vec2 gravity, const Lattice& lattice);

  /// True if accelerations change with place or speed: every body takes substeps, and each substep
  /// asks anew. False: they are the bodies' own constants, good until the lists are made anew.
  bool varying() const { return !wells_.empty() || quadratic_ != 0; }

  /// Fills bodies.acc with the mean accelerations over a substep of h seconds: wells at the
  /// midpoint x + h v / 2 (leapfrog, drift-kick-drift), drag over the substep. h = 0: as they are.
  void accelerations(BodyStore& bodies, double h, WorkerPool& pool) const;

  /// The potential energy a unit of mass has in the wells at p, J/kg.
  double potential(Vec2 p) const;

 private:
  std::vector<WellField> wells_;
  double quadratic_ = 0;
  Vec2 gravity_;
  const Lattice* lattice_;
};

/// Linear drag of all fields, 1/s: part of the damping, integrated exactly.
double linear_drag(const std::vector<Field>& fields);

/// True if the fields ask for accelerations that differ by place or speed.
bool needs_forces(const std::vector<Field>& fields);

/// s^p for s > 0 with the same bits everywhere: products and square roots only. 0 <= p <= 16.
double deterministic_power(double s, double p);

}  // namespace psim
