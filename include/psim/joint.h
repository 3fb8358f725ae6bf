// Joints: what ties two bodies together.
#pragma once

#include <cstdint>
#include <optional>

#include "psim/types.h"

namespace psim {

/// A stable handle of a joint, like BodyId.
struct JointId {
  std::uint32_t index = 0xFFFFFFFFu;
  std::uint32_t generation = 0;
  friend bool operator==(const JointId&, const JointId&) = default;
};

inline constexpr JointId kNoJoint{};

enum class JointType : std::uint8_t {
  distance,   ///< a rod: the anchors stay `length` apart
  spring,     ///< force `stiffness` x stretch + `damping` x its rate along the line of the anchors
  rope,       ///< the anchors come no further apart than `length`
  revolute,   ///< a pin: the anchors coincide; limits and motor on the angle
  prismatic,  ///< a slide: b moves along `axis` of a and does not turn; limits and motor along it
  weld        ///< the anchors coincide and the angle is kept
};

/// One joint. At least one of the bodies must be dynamic. Other than `spring`, joints are rigid;
/// stiffness and damping of a weld soften its angle.
struct JointDesc {
  JointType type = JointType::distance;
  BodyId a, b;
  Vec2 anchor_a, anchor_b;         ///< metres, in the frames of the bodies
  std::optional<double> length;    ///< metres; none: as far apart as the anchors are now
  double stiffness = 0;            ///< spring: N/m; weld: N m/rad, 0 = rigid
  double damping = 0;              ///< spring: N s/m; weld: N m s/rad
  Vec2 axis{1, 0};                 ///< prismatic: direction in a's frame
  std::optional<double> reference; ///< radians: angle b - a that counts as 0; none: the present one
  std::optional<double> lower;     ///< revolute: radians; prismatic: metres; none: no limit
  std::optional<double> upper;
  double motor_speed = 0;          ///< rad/s or m/s
  double motor_limit = 0;          ///< most torque, N m, or force, N; 0: no motor
  bool collide = false;            ///< whether the two bodies still collide
};

/// What a joint does.
struct JointState {
  BodyId a, b;
  JointType type = JointType::distance;
  Vec2 anchor_a, anchor_b;  ///< metres, world
  double value = 0;         ///< distance, spring, rope: length, m; revolute, weld: angle; prismatic: m
  Vec2 force;               ///< N on b, of the last substep
  double torque = 0;        ///< N m on b
};

}  // namespace psim
