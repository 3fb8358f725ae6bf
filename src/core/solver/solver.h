// The contact solver: substeps of impact sweeps, kick, warm start, solve, drift and relax over
// coloured blocks. docs/solver.md derives the scheme; docs/decisions/ has what was measured.
//
// In: contacts with normals and gaps. In and out: velocities, displacements, impulses.
#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
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

/// What the solver works on in a step.
struct SolverInput {
  BodyStore& bodies;
  SolverBodies& solved;
  const PairTable& table;
  ContactStore& contacts;
  Manifolds& manifolds;
  Stacks& stacks;
  JointStore& joints;
  const Forces* forces;  ///< null where accelerations are uniform
  const KinematicBodies& kinematics;
  const kernels::KernelTable& kernels;
  WorkerPool& pool;
};

/// What the passes of a step did.
struct SolverReport {
  double virial = 0;     ///< N s m; m^2/s where all masses are equal: multiply by the mass
  double forces_ms = 0;  ///< time spent on accelerations
};

/// Notes in which sweep over impacts each strip last had an event. If there was no event around a strip since it was
/// looked at, a second look would find the same, and the strip is left out.
struct SweepMemory {
  static constexpr int kNever = -2;
  std::vector<int> pairs, static_pair;  ///< by strip

  void start(std::size_t strips) {
    pairs.assign(strips, kNever);
    static_pair.assign(strips, kNever);
  }
  std::size_t bytes() const { return (pairs.capacity() + static_pair.capacity()) * sizeof(int); }

  /// The bodies of a pair lie in its strip and in the next one; those of the last strip lie anywhere.
  bool asks_pairs(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    const std::size_t next = neighbour(strip, strip + 1 == large, 1);
    return std::max(
               {pairs[strip], pairs[next], pairs[before(strip)], pairs[large], static_pair[strip], static_pair[next]}) +
               1 >=
           sweep;
  }
  bool asks_static(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    return std::max({pairs[strip], pairs[before(strip)], pairs[large], static_pair[strip]}) + 1 >= sweep;
  }

 private:
  std::size_t before(std::size_t strip) const { return neighbour(strip, strip == 0, pairs.size() - 2); }
  // Across a seam the last strip meets the first. There are seams only if the number of strips is even: with an odd
  // number both ends belong to the same phase and may not look at each other.
  std::size_t neighbour(std::size_t strip, bool at_end, std::size_t by) const {
    const std::size_t strips = pairs.size() - 1;
    return at_end && strips % 2 == 1 ? strip : (strip + by) % strips;
  }
};

class Solver {
 public:
  auto fields() { return std::tie(closed_, sweeps_); }  ///< for saved states

  /// Runs all substeps.
  SolverReport run(const SolverInput& in, const SolverParams& params);

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
  void touch_resting(const SolverInput& in);
  void mark_impacts(const SolverInput& in);
  void sum_up(const SolverInput& in, int substeps);

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
