// The contact solver: substeps of impact sweeps, kick, warm start, solve, drift and relax over
// coloured blocks. docs/solver.md derives the scheme; docs/decisions/ has what was measured.
//
// In: contacts with normals and gaps. In and out: velocities, displacements, impulses.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "body_store.h"
#include "columns.h"
#include "contact_store.h"
#include "forces.h"
#include "impact_sweeps.h"
#include "joint_store.h"
#include "kernel_table.h"
#include "manifolds.h"
#include "pair_table.h"
#include "solver_bodies.h"
#include "worker_pool.h"

namespace psim {

/// A step's settings for the solver.
struct SolverParams {
  double dt = 0;
  int substeps = 1;
  double stiff_substep =
      0;  ///< s, that contact stiffness is for: the present one, or on the way to it
  Vec2 gravity;
  double damping = 0;  ///< 1/s
  double pitch_x = 1, pitch_y = 1;
  double restitution_threshold = 0;  ///< m/s
  float refresh = 0;                 ///< m
  double impacts = 0;                ///< that a body has in a substep
  float warm = 1;                    ///< new substep / old substep
  bool turns = false;                ///< points of bodies turn with them: shapes or joints
  ContactModel model;
  int most_sweeps = 0;  ///< over impacts in a substep; 0: as many as it takes
};

/// What the passes of a step did.
struct SolverReport {
  double virial = 0;     ///< N s m, or m^2/s where masses are equal (times the mass)
  double forces_ms = 0;  ///< of the time: spent on accelerations
};

/// Kinematic bodies (ids) with the velocities they keep.
using HeldBodies = std::vector<std::pair<std::uint32_t, Vec2>>;

class Solver {
  friend struct Image;

 public:
  /// Runs all substeps. `forces` is null where accelerations are uniform.
  SolverReport run(BodyStore& bodies, SolverBodies& solved, PairTable& table,
                   ContactStore& contacts, Manifolds& manifolds, Columns& columns, JointStore& joints,
                   const SolverParams& params, const Forces* forces, const HeldBodies& held, const kernels::KernelTable& k,
                   WorkerPool& pool);

  /// Compliance and push-out rate of contacts for a substep of `h`, stiffness as of `stiff_substep`:
  /// between moving bodies, with fixed ones, and the same under heavy loads.
  static void manifold_softness(double h, double stiff_substep, ManifoldParams& params);

  /// Contacts with an impulse at the end of the last run.
  std::uint64_t closed() const { return closed_; }
  /// A step has no contacts, and is none of the solver's.
  void pass() { closed_ = 0; }
  /// Sweeps over impacts that a substep of the last run with restitution took, mean, or would have taken: where they
  /// were limited, as in the runs before, and less and less.
  double sweeps() const { return sweeps_; }

  /// What is there for impacts alone, given back by forget_impacts; and everything.
  std::size_t impact_bytes() const { return touched_.capacity() + pressing_.capacity() + sweep_memory_.bytes(); }
  std::size_t bytes() const {
    return impact_bytes() + loaded_.capacity() * sizeof(std::uint32_t) + held_at_.capacity() * sizeof(float) +
           virial_.capacity() * sizeof(double) + closed_by_strip_.capacity() * sizeof(std::uint64_t);
  }
  void forget_impacts() {
    touched_ = std::vector<std::uint8_t>();
    pressing_ = std::vector<std::uint8_t>();
    sweep_memory_ = {};
  }

 private:
  class Run;
  void find_loaded(const PairTable& table);
  void mark_impacts(const SolverBodies& bodies, PairTable& table, ContactStore& contacts,
                    WorkerPool& pool);
  void sum_up(const PairTable& table, const ContactStore& contacts, int substeps, WorkerPool& pool);

  std::vector<std::uint8_t> touched_;              // by slot: carries a contact
  std::vector<std::uint8_t> pressing_;             // by strip: some of its contacts press
  std::vector<std::uint32_t> loaded_;              // strips with contacts under heavy loads
  std::size_t loaded_odd_ = 0, loaded_large_ = 0;  // where the odd ones and the large group begin
  std::vector<float> held_at_;  // where the held bodies were before a drift, m, records
  std::vector<double> virial_;  // by strip
  std::vector<std::uint64_t> closed_by_strip_;
  std::uint64_t closed_ = 0;
  double sweeps_ = 2;
  SweepMemory sweep_memory_;
};

}  // namespace psim
