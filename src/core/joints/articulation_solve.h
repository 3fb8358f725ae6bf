// What is done to one articulation in a substep. For the files of articulations alone:
//   articulation_equations.cpp  bodies and rows as they are, and the equations between impulses and the errors of rows
//   articulation_solve.cpp      the impulses before the drift
//   articulation_springs.cpp    springs in these
//   articulation_refine.cpp     the same in several steps
//   articulation_finish.cpp     places and velocities after the drift
//   articulation_account.cpp    energy
#pragma once

#include <cstdint>

#include "joints/articulations.h"
#include "least.h"

namespace psim {

class Articulations::Solve {
 public:
  static constexpr double kExact = 3e-8;     // m or rad: an error below this is none
  static constexpr double kAlike = 1e-9;     // softness, of a row's own: rows that ask for the same share their impulse
  static constexpr double kMostGain = 0.3;   // of the energy: what rows of the start may add that those after take back
  static constexpr double kResolved = 1e-4;  // the same where a substep resolves the motion
  static constexpr std::uint32_t kFewestTries = 2;  // of steps in a substep: with fewer it is not tried
  static constexpr double kSturdy = 1e-3;  // the same where steps must not lead far: in rows that hardly move anybody

  Solve(Articulations& all, Island& island, const kernels::BodyView& view)
      : all_(all), island_(island), view_(view), h_(all.h_) {}

  void solve(double drift, double smooth_limit2);
  void finish(double* angle);

 private:
  template <class Each>
  void for_rows(const Each& each) {
    for (std::uint32_t r = island_.rows.begin; r < island_.rows.end; ++r) {
      Row& row = all_.rows_[r];
      each(row, all_.joints_[row.joint]);
    }
  }
  template <class Each>
  void for_bodies(const Each& each) {
    for (std::uint32_t b = island_.bodies.begin; b < island_.bodies.end; ++b) each(all_.bodies_[b]);
  }
  template <class Each>
  void for_joints(const Each& each) {
    for (std::uint32_t n = island_.joints.begin; n < island_.joints.end; ++n) each(all_.joints_[n]);
  }
  const Body& side(const Joint& j, int side) const { return all_.bodies_[j.body[side]]; }
  double speed(const JointRow& row, const Joint& j) const;

  void load_motion(Body& b) const;
  void load_rows();
  void find_rows_now();
  void find_middle_rows();
  double speed_before(const JointRow& row, const Joint& j) const;
  double spring_rest(const Row& row, const Joint& j) const;
  void begin_springs();
  void end_springs();
  bool choose(Row& row, const Joint& j) const;
  double residual(const Row& row, const Joint& j) const;
  /// Inverse masses and inertias of a joint's bodies.
  struct Ends {
    double linear[2] = {}, turning[2] = {};
  };
  static double couple(const JointRow& a, const JointRow& b, const Ends& ends, std::uint8_t shared);
  void assemble(bool across, double softness);
  void eliminate();
  void factorise(bool across, double softness);
  void substitute();
  void push_row(const JointRow& along, const Joint& j, double l);
  // Adds the impulses impulse(row, joint) along the rows of the start or of now.
  template <class Impulse>
  void push(bool at_start, const Impulse& impulse) {
    for_rows([&](Row& row, const Joint& j) {
      const double l = impulse(row, j);
      if (l != 0) push_row(at_start ? row.start : row.now, j, l);
    });
  }
  void move_on(double drift);
  struct Change {
    double square = 0, slope = 0;  // J
  };
  double begin_impulses(const JointedMotion& common);
  Change from_tangent(const JointedMotion& common);
  void stay_within(const JointedMotion& common);
  bool find_impulses(double drift, bool exact);
  void go_along_start();
  void begin_whole();
  double try_whole(double drift);
  void step_damped(double drift);
  bool step_alone(double drift, double share, double most);
  std::uint32_t most_tries() const;
  bool step_on(double drift);
  void set_length(double h, double share);
  bool refine(double drift);
  bool moves();
  void store_velocities();
  bool take_errors_out(double* angle);
  void push_springs();
  void see_limits();
  void find_stopping();
  void stop_errors(double share);
  void settle();
  JointedMotion common_motion();
  JointedMotion moving_with();
  double energy_within(const JointedMotion& common, bool without_kick = false);
  static JointedMotion against(const Body& b, const JointedMotion& common);
  double half_work();
  void push_wanted();
  static JointedMotion without_kick(const Body& b) {
    return {.velocity = b.now.velocity - b.idle, .omega = b.now.omega - b.idle_omega};
  }

  Articulations& all_;
  Island& island_;
  const kernels::BodyView& view_;
  double h_;           // s: of a step
  double reach_ = 1;   // how far a change of velocity leads in the drift, of h
  double gained_ = 0;  // J: since the substep began
};

inline Vec2 load_record(const float* records, std::size_t n) {
  return {static_cast<double>(records[2 * n]), static_cast<double>(records[2 * n + 1])};
}
inline void change(float& to, double v) { to = kernels::snapped(static_cast<double>(to) + v); }
inline void change(float* records, std::size_t n, Vec2 v) {
  change(records[2 * n], v.x);
  change(records[2 * n + 1], v.y);
}

}  // namespace psim
