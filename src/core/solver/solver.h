// The contact solver: substeps of impact sweeps, kick, warm start, solve, drift and relax over
// coloured blocks. docs/solver.md derives the scheme; docs/decisions/ has what was measured.
//
// In: contacts with normals and gaps. In and out: velocities, displacements, impulses.
#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "joints/joint_store.h"
#include "lists/pair_table.h"
#include "manifolds/contacts.h"
#include "solver/applied_forces.h"
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
  bool surfaces = false;             ///< some surfaces run
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
  const Restraints& restraints;
  const ForcesOfStep& pushes;
};

/// What the passes of a step did.
struct SolverReport {
  double virial = 0;     ///< of discs, N s m; m^2/s where all masses are equal: multiply by the mass
  double shapes = 0;     ///< the same of shapes, always N s m
  double forces_ms = 0;  ///< time spent on accelerations
};

/// The time, s, in which a body without damping goes as far as one with damping c, 1/s, goes in h: (1 - exp(-ch)) / c.
double coast_time(double damping, double h);
/// How a time of h seconds kicks and damps bodies under uniform gravity g: dv = g (1 - exp(-ch)) / c. `again`: how many
/// kicks repeat the first one.
kernels::StreamParams kick_params(Vec2 gravity, double damping, double h, int again = 0);

/// What damping does to a velocity in a substep: factors less 1, which floats hold more exactly.
struct Fading {
  float before = 0;  ///< on the velocity before the drift
  float kick = 0;    ///< on what gravity adds to it
  float after = 0;   ///< on the velocity after the drift
};

class Solver {
 public:
  auto fields() { return std::tie(closed_, sweeps_); }  ///< for saved states

  /// Runs all substeps. `moving` becomes true when bodies begin to move; std::bad_alloc is thrown before alone.
  SolverReport run(const SolverInput& in, const SolverParams& params, bool& moving);

  /// Puts bodies that are locked back to where they were before the run, as far as they are. Impacts may have moved them.
  void put_back(BodyStore& bodies, const Restraints& restraints) const;

  /// Compliance and push-out rate of contacts for a substep of `h`, stiffness as of `stiff_substep`:
  /// between moving bodies, with fixed ones, and the same under heavy loads.
  static void manifold_softness(double h, double stiff_substep, ManifoldParams& params);

  /// The number of contacts with an impulse at the end of the last run.
  std::uint64_t closed() const { return closed_; }
  /// The number of pairs that have some.
  std::uint64_t touching() const { return touching_; }
  /// The step has no contacts, so that the solver does not run.
  void skip() { closed_ = touching_ = 0; }
  /// The mean number of sweeps over impacts that a substep needed in the last run with restitution. If the sweeps were
  /// limited, it is the number of the runs before, which slowly fades.
  double sweeps() const { return sweeps_; }

  /// The memory for impacts alone, which forget_impacts gives back; and all memory.
  std::size_t impact_bytes() const { return bytes_of(touched_, bouncing_, pressing_, last_sweep_); }
  std::size_t bytes() const {
    return impact_bytes() + bytes_of(rocking_, loaded_, kinematic_at_, fading_, locked_at_, sums_);
  }
  void forget_impacts() { give_back(touched_, bouncing_, pressing_, last_sweep_); }

 private:
  struct Bouncing {
    std::uint32_t pair, lane;
    std::uint32_t a, b;  // slots; a is b for a pair with a fixed piece
    bool elastic, ahead;
  };
  class Run;
  struct StripSum {
    double virial = 0;           // N s m, of discs
    double shapes = 0;           // and of shapes
    std::uint64_t closed = 0;    // contacts with an impulse
    std::uint64_t touching = 0;  // pairs with such contacts
  };

  void find_loaded(const PairTable& table);
  void touch_resting(const SolverInput& in);
  void mark_impacts(const SolverInput& in);
  void list_bouncing(const SolverInput& in);
  void list_rocking(const SolverInput& in, double dt, double slowest);
  void sum_up(const SolverInput& in, int substeps);

  std::vector<std::uint8_t> touched_;                // by number of a body: it has a contact that presses
  std::vector<std::vector<Bouncing>> bouncing_;      // by strip: the pairs of shapes that may collide in sweeps
  std::vector<std::vector<std::uint32_t>> rocking_;  // by strip: pairs that touch in one point, and may in another one
  std::vector<std::uint8_t> pressing_;               // by strip: some of its contacts press
  std::vector<int> last_sweep_;              // by strip: the last sweep over impacts in which it had an event, or -1
  std::vector<std::uint32_t> loaded_;        // strips with contacts under heavy loads
  std::array<std::size_t, 3> loaded_end_{};  // of even strips, odd strips, the group of large bodies
  std::vector<std::array<float, 2>> kinematic_at_;  // m: the places of kinematic bodies before a drift
  struct Fadings {
    Fading linear, angular;
  };
  struct Stand {
    float x, y;  // m: offset
    double angle;
  };
  std::vector<Fadings> fading_;   // of each restrained body
  std::vector<Stand> locked_at_;  // of each restrained body: where it was before the run
  std::vector<StripSum> sums_;    // by strip
  std::uint64_t closed_ = 0, touching_ = 0;
  double sweeps_ = 2;
};

}  // namespace psim
