// The contact solver: substeps of impact sweeps, kick, warm start, solve, drift and relax over
// coloured blocks. docs/solver.md derives the scheme; docs/decisions/ has what was measured.
//
// In: contacts with normals and gaps. In and out: velocities, displacements, impulses.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "contacts/contact_store.h"
#include "contacts/solver_bodies.h"
#include "joints/joint_store.h"
#include "kernel_table.h"
#include "lists/pair_table.h"
#include "manifolds/manifolds.h"
#include "manifolds/stacks.h"
#include "solver/forces.h"
#include "solver/impact_sweeps.h"

namespace psim {

/// The settings of a step for the solver.
struct SolverParams {
  double dt = 0;
  int substeps = 1;
  double stiff_substep = 0;  ///< s: the substep for which contacts are stiff: the present one, or on the way to it
  Vec2 gravity;
  double damping = 0;  ///< 1/s
  double pitch_x = 1, pitch_y = 1;
  double restitution_threshold = 0;  ///< m/s
  float refresh = 0;                 ///< m
  double impacts = 0;                ///< impacts of a body in a substep
  float warm = 1;                    ///< new substep / old substep
  bool turns = false;                ///< some points turn with their bodies: there are shapes or joints
  ContactModel model;
  int most_sweeps = 0;  ///< most sweeps over impacts in a substep; 0: as many as it takes
};

/// What the passes of a step did.
struct SolverReport {
  double virial = 0;     ///< N s m; m^2/s where all masses are equal: multiply by the mass
  double forces_ms = 0;  ///< time spent on accelerations
};

class Solver {
 public:
  template <class A>
  void describe(A& a);  ///< for saved states

  /// Runs all substeps. `forces` is null where accelerations are uniform.
  SolverReport run(BodyStore& bodies, SolverBodies& solved, PairTable& table, ContactStore& contacts,
                   Manifolds& manifolds, Stacks& stacks, JointStore& joints, const SolverParams& params,
                   const Forces* forces, const KinematicBodies& kinematics, const kernels::KernelTable& k,
                   WorkerPool& pool);

  /// Compliance and push-out rate of contacts for a substep of `h`, stiffness as of `stiff_substep`:
  /// between moving bodies, with fixed ones, and the same under heavy loads.
  static void manifold_softness(double h, double stiff_substep, ManifoldParams& params);

  /// The number of contacts with an impulse at the end of the last run.
  std::uint64_t closed() const { return closed_; }
  /// The step has no contacts, so that the solver does not run.
  void pass() { closed_ = 0; }
  /// The mean number of sweeps over impacts that a substep needed in the last run with restitution. If the sweeps were
  /// limited, it is the number of the runs before, which slowly fades.
  double sweeps() const { return sweeps_; }

  /// The memory for impacts alone, which forget_impacts gives back; and all memory.
  std::size_t impact_bytes() const { return touched_.capacity() + pressing_.capacity() + sweep_memory_.bytes(); }
  std::size_t bytes() const {
    return impact_bytes() + loaded_.capacity() * sizeof(std::uint32_t) + kinematic_at_.capacity() * sizeof(float) +
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
  void mark_impacts(const SolverBodies& bodies, PairTable& table, ContactStore& contacts, WorkerPool& pool);
  void sum_up(const PairTable& table, const ContactStore& contacts, int substeps, WorkerPool& pool);

  std::vector<std::uint8_t> touched_;              // by slot: the body has a contact
  std::vector<std::uint8_t> pressing_;             // by strip: some of its contacts press
  std::vector<std::uint32_t> loaded_;              // strips with contacts under heavy loads
  std::size_t loaded_odd_ = 0, loaded_large_ = 0;  // where the odd strips and the group of large bodies begin
  std::vector<float> kinematic_at_;                // m, records: the places of kinematic bodies before a drift
  std::vector<double> virial_;                     // by strip
  std::vector<std::uint64_t> closed_by_strip_;
  std::uint64_t closed_ = 0;
  double sweeps_ = 2;
  SweepMemory sweep_memory_;
};

}  // namespace psim
