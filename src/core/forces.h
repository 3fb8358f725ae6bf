// Smooth forces: wells, drag, gravity scales, kinematic bodies, and the integrator that moves
// bodies under them. Only worlds that have such things own a Forces; uniform gravity and linear
// damping are part of the kick. The arithmetic is field_kernel.h's, O(bodies x fields).
#pragma once

#include <optional>
#include <vector>

#include "body_store.h"
#include "lattice.h"
#include "psim/desc.h"
#include "views.h"
#include "worker_pool.h"

namespace psim {

class Forces {
 public:
  Forces(const WorldDesc& world, const Lattice& lattice);

  /// True if accelerations change with place or speed: every body takes substeps, and each substep
  /// asks anew. False: they are the bodies' own constants, good until the lists are made anew.
  bool varying() const { return !wells_.empty() || quadratic_ != 0; }

  /// Where the world asks for another integrator than leapfrog: which.
  std::optional<kernels::Method> method() const { return method_; }

  /// What the kernels need for substeps of h seconds; points at the wells of this.
  kernels::FieldParams params(double h) const;

  /// Fills bodies.pull with gravity scales (0: kinematic), and bodies.acc with the accelerations
  /// that uniform gravity then gives. After bodies came, went or were sorted.
  void scale_gravity(BodyStore& bodies, WorkerPool& pool) const;

  /// The potential energy a unit of mass has in the wells at p, J/kg.
  double potential(Vec2 p) const;

 private:
  std::vector<WellField> wells_;
  std::vector<kernels::WellTerms> terms_;  // of the wells, in their order
  double linear_ = 0;                      // 1/s: drag and damping
  double quadratic_ = 0;                   // 1/m
  Vec2 gravity_;
  std::optional<kernels::Method> method_;
  const Lattice* lattice_;
};

/// What rounding took from velocities and offsets follows the bodies, which a sort moved from slot
/// from[i] to slot i. Padding has none.
void move_rests(BodyStore& bodies, const std::uint32_t* from, WorkerPool& pool);

/// Linear drag of all fields, 1/s: part of the damping, integrated exactly.
double linear_drag(const std::vector<Field>& fields);

/// True if the fields ask for accelerations that differ by place or speed.
bool needs_forces(const std::vector<Field>& fields);

/// s^p for s > 0 with the same bits everywhere: products and square roots only. 0 <= p <= 16.
double deterministic_power(double s, double p);

}  // namespace psim
