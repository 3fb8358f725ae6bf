/// @file
/// C API: joints.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What a joint does, by the state after the last step.
typedef struct psim_joint_state {
  psim_body_id a;      ///< as described
  psim_body_id b;      ///< as described
  int32_t type;        ///< psim_joint_type
  int32_t reserved;    ///< 0
  psim_vec2 anchor_a;  ///< metres, world
  psim_vec2 anchor_b;  ///< metres, world
  /// distance, spring, rope, target: length, m; revolute, weld, motor: angle, rad; prismatic, wheel: m along the axis;
  /// gear: the sum that it keeps; pulley: way to a + ratio x way to b, m; filter: 0
  double value;
  psim_vec2 force;  ///< N on b, of the last substep
  double torque;    ///< N m on b
} psim_joint_state;

/// Ties two bodies and puts the handle into `id` (may be NULL).
PSIM_API psim_result psim_world_add_joint(psim_world* world, const psim_joint_desc* desc, psim_joint_id* id);

/// Removes a joint. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_remove_joint(psim_world* world, psim_joint_id id);

/// 1 if the joint is there, else 0. Removing a body removes its joints.
PSIM_API int32_t psim_world_is_valid_joint(const psim_world* world, psim_joint_id id);

/// What a joint does. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_joint(const psim_world* world, psim_joint_id id, psim_joint_state* state);

/// How fast psim_joint_state.value grows, m/s or rad/s. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_joint_speed(const psim_world* world, psim_joint_id id, double* speed);

/// The description of a joint: lengths, references, stiffness and damping that follow from others are set, and
/// `frequency` is 0. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_joint_desc(const psim_world* world, psim_joint_id id, psim_joint_desc* desc);

/// Gives a joint another description of the same type and bodies. Both bodies wake. PSIM_ERROR_STALE_ID;
/// PSIM_ERROR_ARGUMENT, and nothing changes, if it is refused.
PSIM_API psim_result psim_world_set_joint(psim_world* world, psim_joint_id id, const psim_joint_desc* desc);

/// Target: moves the point of the world that pulls, metres. The body wakes. PSIM_ERROR_STALE_ID; PSIM_ERROR_ARGUMENT for
/// other joints or a number out of its range.
PSIM_API psim_result psim_world_set_target(psim_world* world, psim_joint_id id, psim_vec2 point);

/// Distance, revolute, prismatic and wheel: rad/s and N m, or m/s and N; a limit of 0 stops the motor.
/// PSIM_ERROR_STALE_ID; PSIM_ERROR_ARGUMENT for other joints, a number out of its range or a
/// negative limit.
PSIM_API psim_result psim_world_set_motor(psim_world* world, psim_joint_id id, double speed, double limit);

/// All joints; 0 for NULL.
PSIM_API size_t psim_world_joint_count(const psim_world* world);

/// The joints of a body, by index. `*count` gets how many there are; `ids` (may be NULL) has room for `capacity` of them.
PSIM_API psim_result psim_world_joints_of(const psim_world* world, psim_body_id id, psim_joint_id* ids, size_t capacity,
                                          size_t* count);

/// The joints whose lines the segment from `from` to `to`, metres, crosses or touches, by index: the lines that
/// psim_world_debug_draw draws of them. None if a number is not finite. `*count` gets how many there are; `ids` (may be
/// NULL) has room for `capacity` of them.
PSIM_API psim_result psim_world_joints_across(const psim_world* world, psim_vec2 from, psim_vec2 to, psim_joint_id* ids,
                                              size_t capacity, size_t* count);

#ifdef __cplusplus
}
#endif
