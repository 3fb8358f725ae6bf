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

/// The world as a body of a joint: anchors at it are points of the world.
inline constexpr BodyId kWorldBody{0xFFFFFFFEu, 0};

/// What a joint allows.
enum class JointType : std::uint8_t {
  distance,  ///< a rod: the anchors stay `length` apart; or, see JointDesc, a spring, ends and a motor along their line
  spring,    ///< force `stiffness` x stretch + `damping` x its rate along the line of the anchors
  rope,      ///< the anchors come no further apart than `length`
  revolute,  ///< a pin: the anchors coincide; spring, limits and motor on the angle
  prismatic,  ///< a slide: b moves along `axis` of a and does not turn; spring, limits and motor along it
  weld,       ///< the anchors coincide and the angle is kept; either may be soft
  wheel,      ///< b moves along `axis` of a, with spring and limits, and turns freely or by the motor
  motor,      ///< drives b against a: at `linear_velocity` and `angular_velocity`, or to a place and an angle
  target,     ///< a spring from the point `target` of the world, which the host moves, to the anchor of b
  gear,       ///< the way of one joint + `ratio` x that of another one stays what it is
  pulley,     ///< a rope over two points of the world: the way to a + `ratio` x the way to b is `length` at most
  filter      ///< the two bodies do not collide, nothing else
};

/// One joint. At least one of the bodies must be dynamic. Rows without a spring are rigid.
struct JointDesc {
  JointType type = JointType::distance;  ///< what it allows
  BodyId a = {};                         ///< a body or kWorldBody; target: not asked for
  BodyId b = {};                         ///< another
  Vec2 anchor_a = {};                    ///< metres, in the frame of a; kWorldBody: a point of the world
  Vec2 anchor_b = {};                    ///< metres, in the frame of b
  /// metres; none: as far apart as the anchors are now. Pulley: way to a + ratio x way to b.
  std::optional<double> length = {};
  /// N/m, along a line or an axis; N m/rad of an angle (revolute, weld). 0: no spring; weld: rigid.
  double stiffness = 0;
  double damping = 0;                    ///< N s/m or N m s
  Vec2 axis{1, 0};                       ///< prismatic, wheel: direction in a's frame
  std::optional<double> reference = {};  ///< radians: angle b - a that counts as 0; none: the present one
  std::optional<double> lower = {};      ///< revolute: radians; distance, prismatic, wheel: metres; none: no limit
  std::optional<double> upper = {};      ///< as lower, and not below it
  double motor_speed = 0;                ///< rad/s (revolute, wheel) or m/s
  double motor_limit = 0;                ///< most torque, N m, or force, N; 0: no motor
  bool collide = false;                  ///< whether the two bodies still collide
  Vec2 target = {};                      ///< target: metres, a point of the world
  double rest = 0;                       ///< revolute, radians; prismatic, metres: where the spring rests
  Vec2 linear_velocity = {};             ///< motor: m/s, of b's anchor against the point of a there
  double angular_velocity = 0;           ///< motor: rad/s, of b against a
  double force_limit = 0;                ///< motor, target: N; 0: motor: no force, target: any force
  double torque_limit = 0;               ///< motor: N m; 0: no torque
  Vec2 ground_a = {};                    ///< pulley: metres, the point of the world over which the rope goes to a
  Vec2 ground_b = {};                    ///< pulley: metres, the same to b
  double ratio = 1;                      ///< gear, pulley: see JointType
  JointId joint_a = {};                  ///< gear: a revolute or prismatic joint
  JointId joint_b = {};                  ///< gear: another one
  /// Hz: how fast the spring swings alone, from which stiffness and damping follow when the joint is made.
  std::optional<double> frequency = {};
  double damping_ratio = 0;     ///< with frequency: 1 is the least damping without a swing
  double break_force = 0;       ///< N: gone after a step with more in the mean, the most loaded first; 0: never
  double break_torque = 0;      ///< N m: the same
  std::uint64_t user_data = 0;  ///< 64 bits of the host
  double linear_stiffness = 0;  ///< weld: N/m, of a spring that holds the anchors together; 0 and no damping: rigid
  double linear_damping = 0;    ///< weld: N s/m, of that spring
  /// motor: 0 to 1, of the way to `offset` and `reference`: the share that each step makes up, beside the velocities,
  /// as far as the limits let it. 0: there is no such place.
  double correction = 0;
  Vec2 offset = {};  ///< motor: metres, in the frame of a: from its anchor to that of b
  /// distance, spring, rope: N/m, -1e12 to 1e12: pushes with this x the way between the anchors, half at each of them, to
  /// the right of the way from a to b: outwards if joints go round a ring counter-clockwise. weld: between the centres of
  /// mass of its bodies, as wind_drag, wind_lift and area, for its anchors coincide.
  double pressure = 0;
  double wind_drag =
      0;  ///< distance, spring, rope, weld: 0 to 1000: the joint catches wind, see WindField, with this as drag
  double wind_lift =
      0;  ///< 0 to 1000: and with this as lift, on either of its sides; masks of winds are of bodies alone
  /// distance, spring, rope, weld: m^2, -1e18 to 1e18: where joints with an area close a ring, from a to b all the way round, it
  /// keeps the sum of their areas inside, counter-clockwise, as stiffly as its substeps allow. 0: no part of such a ring.
  double area = 0;
};

/// What a joint does.
struct JointState {
  BodyId a = {};                         ///< as described
  BodyId b = {};                         ///< as described
  JointType type = JointType::distance;  ///< as described
  Vec2 anchor_a = {};                    ///< metres, world
  Vec2 anchor_b = {};                    ///< metres, world
  /// distance, spring, rope, target: length, m; revolute, weld, motor: angle, rad; prismatic, wheel: m along the axis;
  /// gear: the sum that it keeps; pulley: way to a + ratio x way to b, m; filter: 0
  double value = 0;
  Vec2 force = {};    ///< N on b, of the last substep; while its bodies sleep 0, as `torque`
  double torque = 0;  ///< N m on b
  double speed = 0;   ///< m/s or rad/s: how fast `value` grows
};

/// A joint was loaded with more than it bears, and is gone.
struct JointBreak {
  JointId joint = {};           ///< its handle, of nothing any more
  BodyId a = {};                ///< as described
  BodyId b = {};                ///< as described
  Vec2 point = {};              ///< metres: the anchor at b
  Vec2 force = {};              ///< N on b, the mean of the step
  double torque = 0;            ///< N m on b, the mean of the step
  std::uint64_t user_data = 0;  ///< JointDesc::user_data
};

}  // namespace psim
