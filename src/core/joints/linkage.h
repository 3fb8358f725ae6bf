// A joint that is solved row by row in double precision: what has a spring, ends and a motor at once, several motors, or
// more than two bodies. docs/joints.md says what its rows are.
#pragma once

#include <array>
#include <cstdint>

#include "base/rotor.h"
#include "joints/articulation_rows.h"
#include "joints/spring_row.h"
#include "psim/joint.h"

namespace psim {

/// The share of a row at one body: the speed of the row is the sum of n v + arm omega over the bodies of the joint.
struct Lever {
  Vec2 n{};
  double arm = 0;  ///< m, or 1 for an angle
};

/// A body of a linkage.
struct LinkageEnd {
  std::uint32_t body = 0;    ///< its id
  std::uint32_t member = 0;  ///< its number in JointStore
  std::uint32_t number = 0;  ///< the number that the solver uses
  double inverse_mass = 0, inverse_inertia = 0;
  double turning = 0;  ///< 1/(kg m^2): the inverse inertia as far as the load lets the body turn
  double radius = 1;   ///< m: over which rim speeds are held
  double angle = 0;    ///< rad: at the frame's start
  Vec2 arm;            ///< m: from its centre to its anchor, now
  Lever half;          ///< N s, N m s: half of what turning the impulses adds

  bool moves() const { return inverse_mass > 0 || inverse_inertia > 0; }
};

/// Two bodies of a linkage as an ordinary joint has them: its end 0 is A.
struct LinkagePart {
  JointType type = JointType::distance;  ///< revolute, prismatic, wheel, motor, target, distance
  std::uint8_t end[2] = {0, 1};
  Vec2 base;       ///< m: from A's centre to B's at the frame's start
  Vec2 anchor[2];  ///< m: from the centres, in the frames of the bodies
  Vec2 axis{1, 0};
  double reference = 0;  ///< rad
};

struct LinkageRow {
  static constexpr std::uint32_t kMost = 4;

  std::array<Lever, 4> lever;  ///< by end
  double value = 0;            ///< m or rad
  double bend = 0;             ///< 1/m: how much the row turns on a way across it
  double curve = 0;            ///< h x the acceleration of the value by itself
  double impulse = 0;          ///< N s or N m s
  double mass = 0;             ///< kg or kg m^2, while the rigid rows hold; 0: nothing moves it
  double held[2] = {};         ///< what an impulse of 1 takes along in the rigid rows
};

/// A row that is not rigid: a spring, two ends and a motor.
struct LinkageDrive {
  static constexpr std::uint32_t kMost = 3;

  std::uint32_t row = 0;
  SpringRow spring;
  double rest = 0, lower = 0, upper = 0;  ///< m or rad
  double speed = 0, most = 0;             ///< of the motor; N s or N m s
  double spring_l = 0, limit_l = 0, motor_l = 0;

  double sum() const { return spring_l + limit_l + motor_l; }
};

/// Rigid rows come first, then one for each drive. Where `paired`, the first two drives are x and y of a vector: their
/// impulses together have a limit, `most` of the first one, or none if that is infinite.
struct Linkage {
  static constexpr std::uint32_t kMostEnds = 4;

  JointType type = JointType::distance;
  std::uint32_t ends = 0, rows = 0, rigid = 0, drives = 0;
  bool paired = false;
  double ratio = 0;        ///< of the second part; 0: there is none
  double length = 0;       ///< m or rad: what the first row counts from
  double inverse[3] = {};  ///< of the first two rows: xx, xy, yy; of one rigid row: xx
  std::array<LinkageEnd, kMostEnds> end;
  LinkagePart part[2];
  std::array<LinkageRow, LinkageRow::kMost> row;
  std::array<LinkageDrive, LinkageDrive::kMost> drive;

  /// Sets which rows a joint of this type has, and which of them are rigid.
  void set_type(JointType of);
  /// Its impulses, for saved states.
  template <class Each>
  void each_impulse(const Each& each) {
    for (LinkageRow& r : row) each(r.impulse);
    for (LinkageDrive& d : drive) each(d.spring_l), each(d.limit_l), each(d.motor_l);
  }
};

/// Sets levers, values and arms for bodies that are where `motion`, by end, tells.
void find_rows(Linkage& linkage, const JointedMotion* motion);
/// Sets masses from these, and how far the bodies turn under the impulses of a substep of h seconds.
void find_masses(Linkage& linkage, double h);

}  // namespace psim
