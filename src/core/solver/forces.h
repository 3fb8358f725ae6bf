// Smooth forces: wells, drag, gravity scales, kinematic bodies, and the integrator that moves
// bodies under them. Only worlds that have such things own a Forces; uniform gravity and linear
// damping are part of the kick. field_kernel.h has the arithmetic. O(bodies x fields).
#pragma once

#include <optional>
#include <vector>

#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "psim/desc.h"
#include "views.h"

namespace psim {

class Forces {
 public:
  Forces(const WorldDesc& world, const Lattice& lattice);

  /// Whether accelerations change with place or speed. Then every body takes substeps, and each substep computes them
  /// anew; else they are constants of the bodies until the lists are made anew.
  bool varying() const { return !terms_.empty() || quadratic_ != 0; }

  /// The integrator, if the world asks for another one than leapfrog.
  std::optional<kernels::Method> method() const;

  /// The parameters of the kernels for substeps of h seconds. They point at the wells of this object.
  kernels::FieldParams params(double h) const;

  /// Fills bodies.pull with gravity scales (0 for kinematic bodies), and bodies.acc with the accelerations that uniform
  /// gravity then gives. Runs after bodies came, went or were sorted.
  void scale_gravity(BodyStore& bodies, WorkerPool& pool) const;

  /// The potential energy a unit of mass has in the wells at p, J/kg.
  double potential(Vec2 p) const;

 private:
  const WorldDesc& world_;
  const Lattice& lattice_;
  std::vector<kernels::WellTerms> terms_;  // a term for each well, in their order
  double linear_ = 0;                      // 1/s: drag and damping
  double quadratic_ = 0;                   // 1/m
};

/// Moves the remainders of velocities and offsets along with the bodies, after a sort moved these from slot from[i] to
/// slot i. Padding has no remainders.
void move_remainders(BodyStore& bodies, const std::uint32_t* from, WorkerPool& pool);
/// Call before the sort: move_remainders() needs no memory then.
void make_room_for_remainders(BodyStore& bodies);

/// Linear drag of all fields, 1/s: part of the damping, integrated exactly.
double linear_drag(const std::vector<Field>& fields);

/// Whether the fields need accelerations that differ by place or speed.
bool needs_forces(const std::vector<Field>& fields);

/// s^p for s > 0 with the same bits everywhere: products and square roots only. 0 <= p <= 16.
double deterministic_power(double s, double p);

}  // namespace psim
