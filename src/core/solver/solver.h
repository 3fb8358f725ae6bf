// The contact solver: substeps of impact sweeps, kick, warm start, solve, drift and relax over
// coloured blocks. docs/solver.md derives the scheme; docs/decisions/ has what was measured.
//
// In: contacts with normals and gaps. In and out: velocities, displacements, impulses.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "joints/joint_store.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"
#include "solver/forces.h"

namespace psim {

/// The settings of a step for the solver.
struct SolverParams {
  double dt = 0;
  int substeps = 1;
  double stiff_substep = 0;  ///< s: the substep for which contacts are stiff: the present one, or on the way to it
  Vec2 gravity;
  double damping = 0;                ///< 1/s
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
  Contacts& contacts;
  const PairTable& table;
  JointStore& joints;
  const Forces* forces;  ///< null where accelerations are uniform
  const KinematicBodies& kinematics;
};

/// What the passes of a step did.
struct SolverReport {
  double virial = 0;     ///< N s m; m^2/s where all masses are equal: multiply by the mass
  double forces_ms = 0;  ///< time spent on accelerations
};

/// Notes in which sweep over impacts each strip last had an event. If there was no event around a strip since it was
/// looked at, a second look would find the same, and the strip is left out.
class SweepMemory {
 public:
  void start(std::size_t strips) { last_.assign(strips, {}); }
  void note_pairs(std::size_t strip, int sweep) { last_[strip].pairs = sweep; }
  void note_statics(std::size_t strip, int sweep) { last_[strip].statics = sweep; }
  std::size_t bytes() const { return last_.capacity() * sizeof(Last); }

  /// The bodies of a pair lie in its strip and in the next one; those of the last strip lie anywhere.
  bool asks_pairs(std::size_t strip, int sweep) const {
    if (strip + 1 == last_.size()) return true;
    const std::size_t next = neighbour(strip, strip + 2 == last_.size(), 1);
    return std::max(last_at(strip), last_at(next)) + 1 >= sweep;
  }
  bool asks_statics(std::size_t strip, int sweep) const {
    return strip + 1 == last_.size() || last_at(strip) + 1 >= sweep;
  }

 private:
  struct Last {
    int pairs = -1, statics = -1;  // -1: never
  };
  // The last sweep with an event of a body of the strip.
  int last_at(std::size_t strip) const {
    const std::size_t before = neighbour(strip, strip == 0, last_.size() - 2);
    return std::max({last_[strip].pairs, last_[before].pairs, last_.back().pairs, last_[strip].statics});
  }
  // Across a seam the last strip meets the first. There are seams only if the number of strips is even: with an odd
  // number both ends belong to the same phase and may not look at each other.
  std::size_t neighbour(std::size_t strip, bool at_end, std::size_t by) const {
    const std::size_t strips = last_.size() - 1;
    return at_end && strips % 2 == 1 ? strip : (strip + by) % strips;
  }

  std::vector<Last> last_;  // by strip
};

/// The time, s, in which a body without damping goes as far as one with damping c, 1/s, goes in h: (1 - exp(-ch)) / c.
double coast_time(double damping, double h);
/// How a time of h seconds kicks and damps bodies under uniform gravity g: dv = g (1 - exp(-ch)) / c.
kernels::StreamParams kick_params(Vec2 gravity, double damping, double h);

class Solver {
 public:
  template <class A>
  void describe(A& a) {  // for saved states
    values(a, closed_, sweeps_);
  }

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
    const auto of = [](const auto&... v) { return ((v.capacity() * sizeof(v[0])) + ...); };
    return impact_bytes() + of(loaded_, kinematic_at_, sums_);
  }
  void forget_impacts() {
    touched_ = std::vector<std::uint8_t>();
    pressing_ = std::vector<std::uint8_t>();
    sweep_memory_ = {};
  }

 private:
  class Run;
  struct StripSum {
    double virial = 0;         // N s m
    std::uint64_t closed = 0;  // contacts with an impulse
  };

  void find_loaded(const PairTable& table);
  void touch_resting(const SolverInput& in);
  void mark_impacts(const SolverInput& in);
  void sum_up(const SolverInput& in, int substeps);

  std::vector<std::uint8_t> touched_;               // by slot: the body has a contact
  std::vector<std::uint8_t> pressing_;              // by strip: some of its contacts press
  SweepMemory sweep_memory_;                        // by strip
  std::vector<std::uint32_t> loaded_;               // strips with contacts under heavy loads
  std::array<std::size_t, 3> loaded_end_{};         // of even strips, odd strips, the group of large bodies
  std::vector<std::array<float, 2>> kinematic_at_;  // m: the places of kinematic bodies before a drift
  std::vector<StripSum> sums_;                      // by strip
  std::uint64_t closed_ = 0;
  double sweeps_ = 2;
};

}  // namespace psim
