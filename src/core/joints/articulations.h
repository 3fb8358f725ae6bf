// Articulations: bodies on joints that are solved together, exactly. Chains, ragdolls, trusses and machines are; where
// bodies have too many joints for that (nets, crowds of ragdolls), the joint store sweeps over their joints instead.
//
//   lay_out   finds the articulations when joints come, go, fall asleep or wake, and the order of elimination
//   prepare   once a frame, after the joints and bodies were set for it
//   solve     once a substep, before the drift: impulses with which the drift ends where the joints hold
//   finish    after the drift: takes what is left of the errors out of the places, and out of the velocities
//
// docs/joints.md derives the scheme. Articulations share no dynamic body, so that they run side by side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "joints/articulation_rows.h"
#include "joints/spring_row.h"
#include "views.h"

namespace psim {

class Articulations {
 public:
  /// A joint that may be solved here, and its bodies.
  struct Candidate {
    std::uint32_t joint = 0, body[2] = {0, 0};
    bool dynamic[2] = {false, false};
    bool limited = false;  ///< a pin with limits
    kernels::JointKind kind = kernels::JointKind::rod;
  };
  struct Body {
    std::uint32_t id = 0;                          ///< that of the candidates
    std::uint32_t number = 0;                      ///< of the solver
    std::uint32_t slot = 0;                        ///< of bodies that move
    double inverse_mass = 0, inverse_inertia = 0;  ///< 0: it is not dynamic
    double radius = 1;                             ///< m: rim speeds are omega times it
    double angle = 0;                              ///< rad: at the frame's start
    Vec2 place{};                                  ///< m: at the frame's start, from the first body
    JointedMotion start{};                         ///< as the substep begins, with the velocities of the drift
    JointedMotion now{};
    JointedMotion mark{};      ///< as a step of its own begins, or a pass
    JointedMotion begin{};     ///< as the substep begins, with the whole kick
    Vec2 pull{};               ///< m/s: the kick, if the drift goes with half of it
    Vec2 after{};              ///< m/s: added after the drift
    double after_omega = 0;    ///< rad/s: the same
    Vec2 kick{};               ///< m/s: by gravity and contacts, in this substep
    double kick_omega = 0;     ///< rad/s: the same
    Vec2 tangent{};            ///< m/s: the motion that the rows of the start allow
    double tangent_omega = 0;  ///< rad/s
    Vec2 idle{};               ///< m/s: how much of it the account leaves out
    double idle_omega = 0;     ///< rad/s: the same
  };
  struct Joint {
    JointGeometry geometry{};
    std::uint32_t joint = 0;         ///< that of the candidates
    std::uint32_t body[2] = {0, 0};  ///< A and B
    std::uint32_t first_row = 0;
    bool rope = false;
    double lower = -1e30, upper = 1e30;      ///< of a drive: rad or m
    double motor_speed = 0, motor_most = 0;  ///< rad/s or m/s; N m s or N s a substep
    double stiffness = 0, damping = 0;       ///< of a spring: N/m and N s/m, or N m/rad and N m s/rad
    double mass = 0;                         ///< of a spring: its effective mass, kg or kg m^2
    std::uint32_t crowd = 1;                 ///< the most springs at one of its bodies
    SpringRow spring;
    float* impulse = nullptr;  ///< of the last substep, as JointLists::each_impulse has them
    float* gain = nullptr;     ///< J: what the joint gave to its bodies so far, less what was taken back

    /// For steps of h seconds.
    void set_spring(double h) { spring = spring_row(stiffness, damping, mass, h, crowd); }
  };

  void lay_out(std::span<const Candidate> candidates);
  /// `calm`: bodies may sleep.
  void prepare(double h, bool calm);
  /// `drift`: the length of the drift, s. It goes by the mean velocity where the square of the change is at most
  /// `smooth_limit2`.
  void solve(const kernels::BodyView& view, double drift, double smooth_limit2, WorkerPool& pool);
  /// `angle`: by slot.
  void finish(const kernels::BodyView& view, double* angle, WorkerPool& pool);

  std::span<Joint> joints() { return joints_; }
  std::span<const Joint> joints() const { return joints_; }
  std::span<Body> bodies() { return bodies_; }
  bool empty() const { return joints_.empty(); }
  std::size_t bytes() const {
    return bytes_of(islands_, bodies_, joints_, rows_, columns_, couplings_, targets_, upper_, lower_, walk_);
  }
  void release() {
    give_back(islands_, bodies_, joints_, rows_, columns_, couplings_, targets_, upper_, lower_, walk_);
  }

 private:
  /// What a row asks for.
  enum class Use : std::uint8_t { keep, pull, spring, drive };  // pull: ropes
  /// Whether its impulse is looked for. A drive stands at its lower or upper limit (low, high), or has a motor that
  /// follows its speed (bound) or gives all it can (full).
  enum class State : std::uint8_t { free, bound, low, high, full };

  struct Range {
    std::uint32_t begin = 0, end = 0;
  };
  struct Island {
    Range bodies, joints, rows, walk;
    std::uint32_t held = kNone;  ///< a body that is not dynamic
    double gained = 0;           ///< J: since the substep began
    bool refined = false;        ///< it goes through the substep in several steps
    double apart = 0;            ///< J: of what turning rows did beyond the tangent motion
  };
  struct Row {
    JointRow start{}, now{};  ///< of springs: in the middle of the step, but for the error, which is that at its start
    Use use = Use::keep;
    State state = State::bound, mark = State::bound;
    std::uint32_t joint = 0;
    double impulse = 0;   ///< of this substep
    double sum = 0;       ///< of several steps
    double tangent = 0;   ///< what the speeds at the start ask for
    double wanted = 0;    ///< of the equations: the right side, then the solution
    double softness = 0;  ///< of springs: 1 / drag, 1/kg
    double before = 0;    ///< of springs: the speed as the step begins, before the kick
    double diagonal = 0, inverse = 0;
    Range entries{};                 ///< the rows behind it that it is coupled with
    std::uint32_t first_target = 0;  ///< in targets_

    bool on() const { return state == State::bound || state == State::low || state == State::high; }
  };
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  class Elimination;  // articulation_layout.cpp
  class Solve;        // articulation_solve.cpp

  void add(std::span<const Candidate> group, const Elimination& order);
  void couple(const Island& island);
  void find_walk(Island& island);

  double h_ = 0;      // s: a substep
  double reach_ = 1;  // how far a velocity leads in the drift, of h
  bool calm_ = false;
  std::vector<Island> islands_;
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;            // in the order of elimination
  std::vector<Row> rows_;                // in that order
  std::vector<std::uint32_t> columns_;   // by entry: the row behind
  std::vector<std::uint8_t> couplings_;  // by entry: which bodies the two rows share
  std::vector<std::uint32_t> targets_;   // by pair of a row's entries: the entry that elimination changes
  std::vector<double> upper_, lower_;    // by entry
  std::vector<std::uint32_t> walk_;      // joints from body to body, 2 joint + the side that is reached
};

}  // namespace psim
