// The rows of a joint at given poses, in double precision: how far the joint is from what it asks, and how a motion of
// its two bodies changes that. docs/joints.md lists them.
#pragma once

#include <cstdint>

#include "base/rotor.h"
#include "joint_views.h"

namespace psim {

/// Where a body is and how it moves. `at` counts from the frame's start.
struct JointedMotion {
  Vec2 at{};         ///< m
  double angle = 0;  ///< rad
  SineCosine turn{};
  Vec2 velocity{};   ///< m/s
  double omega = 0;  ///< rad/s
};

/// How many rows a joint has.
inline std::uint32_t rows_of(kernels::JointKind kind) {
  using kernels::JointKind;
  return kind == JointKind::rod || kind == JointKind::spring ? 1 : kind == JointKind::pin ? 2 : 3;
}

/// A joint between the bodies A and B as its description and this frame's start tell.
struct JointGeometry {
  kernels::JointKind kind = kernels::JointKind::rod;
  Vec2 base{};           ///< m: from A's centre to B's at the frame's start
  Vec2 anchor[2] = {};   ///< m: from the centres, in the frames of A and B
  Vec2 axis{};           ///< slides: in the frame of A
  double length = 0;     ///< m
  double reference = 0;  ///< rad: the angle B - A that counts as 0

  std::uint32_t rows() const { return rows_of(kind); }
};

/// The speed of a row's error is n (v_B - v_A) + arm_b omega_B - arm_a omega_A.
struct JointRow {
  double error = 0;  ///< m or rad
  Vec2 n{};
  double arm_a = 0, arm_b = 0;  ///< m, or 1 for an angle

  double speed(const JointedMotion& a, const JointedMotion& b) const {
    return dot(n, b.velocity - a.velocity) + arm_b * b.omega - arm_a * a.omega;
  }
};

/// Writes the rows of a joint, at most three: of rods, ropes and springs the distance; of pins and welds x and y of B's
/// anchor from A's, then the angle; of slides the way across the axis, the angle, the way along it.
void find_rows(const JointGeometry& joint, const JointedMotion& a, const JointedMotion& b, JointRow* rows);

/// Turns the row of a spring in the middle of a step: how the way from `a0` and `b0` to `a` and `b` adds up to the change
/// of the distance, exactly (the discrete gradient; Gonzalez 1996). Its error stays.
void find_middle(const JointGeometry& joint, const JointedMotion& a0, const JointedMotion& b0, const JointedMotion& a,
                 const JointedMotion& b, JointRow& row);

}  // namespace psim
