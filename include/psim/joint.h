// Joints: what ties two bodies together.
#pragma once

#include <cstdint>
#include <optional>

#include "psim/types.h"

namespace psim {

/// A stable handle of a joint, like BodyId.
struct JointId {
  std::uint32_t index = 0xFFFFFFFFu;  ///< counts from 0, reused after a removal
  std::uint32_t generation = 0;       ///< how many joints had the index before
  /// The same joint.
  friend bool operator==(const JointId&, const JointId&) = default;
};

/// No joint.
inline constexpr JointId kNoJoint{};

/// What a joint allows.
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
  JointType type = JointType::distance;  ///< what it allows
  BodyId a = {};                         ///< a body
  BodyId b = {};                         ///< another
  Vec2 anchor_a = {};                    ///< metres, in the frame of a
  Vec2 anchor_b = {};                    ///< metres, in the frame of b
  std::optional<double> length = {};     ///< metres; none: as far apart as the anchors are now
  double stiffness = 0;                  ///< spring: N/m; weld: N m/rad, 0 = rigid
  double damping = 0;                    ///< spring: N s/m; weld: N m s/rad
  Vec2 axis{1, 0};                       ///< prismatic: direction in a's frame
  std::optional<double> reference = {};  ///< radians: angle b - a that counts as 0; none: the present one
  std::optional<double> lower = {};      ///< revolute: radians; prismatic: metres; none: no limit
  std::optional<double> upper = {};      ///< as lower, and not below it
  double motor_speed = 0;                ///< rad/s or m/s
  double motor_limit = 0;                ///< most torque, N m, or force, N; 0: no motor
  bool collide = false;                  ///< whether the two bodies still collide
};

/// What a joint does.
struct JointState {
  BodyId a = {};                         ///< as described
  BodyId b = {};                         ///< as described
  JointType type = JointType::distance;  ///< as described
  Vec2 anchor_a = {};                    ///< metres, world
  Vec2 anchor_b = {};                    ///< metres, world
  double value = 0;                      ///< distance, spring, rope: length, m; revolute, weld: angle; prismatic: m
  Vec2 force = {};                       ///< N on b, of the last substep
  double torque = 0;                     ///< N m on b
};

}  // namespace psim
