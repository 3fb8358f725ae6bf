/// @file
/// C API: bodies come, go, and are pushed.
#pragma once

#include "psim/c/contacts.h"
#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// One body: place and motion.
typedef struct psim_body_state {
  psim_body_id id;   ///< its handle
  double x;          ///< metres: of its origin, psim_body_desc::position
  double y;          ///< metres
  double angle;      ///< radians, not wrapped
  double vx;         ///< m/s: of the centre of mass; kinematic: of (x, y)
  double vy;         ///< m/s
  double omega;      ///< rad/s
  double radius;     ///< metres: of the circle that holds it; static: 0 unless a disc
  int32_t type;      ///< psim_body_type
  int32_t reserved;  ///< 0
} psim_body_state;

/// Adds a body and puts its handle into `id` (may be NULL). Ids count from 0 in the order of the
/// calls. O(1) amortised.
PSIM_API psim_result psim_world_add_body(psim_world* world, const psim_body_desc* desc, psim_body_id* id);

/// Adds bodies whose descriptions lie `stride` bytes apart (sizeof(psim_body_desc) for an array). The
/// first that is refused ends the call: `added` (may be NULL) says how many there are before it, and
/// psim_last_error names it. `ids` (may be NULL) has room for `count` handles.
PSIM_API psim_result psim_world_add_bodies(psim_world* world, const psim_body_desc* descs, size_t count, size_t stride,
                                           psim_body_id* ids, size_t* added);

/// Adds discs in bulk, all or none; `first` (may be NULL) is the index of the first. The indices are
/// consecutive if no body was removed before. A million in well under a second.
PSIM_API psim_result psim_world_add_discs(psim_world* world, const psim_disc_batch* batch, uint32_t* first);

/// Removes a body and its joints. What leaned on it falls. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_remove_body(psim_world* world, psim_body_id id);

/// 1 if the body is there, else 0.
PSIM_API int32_t psim_world_is_valid(const psim_world* world, psim_body_id id);

/// The handle of the body of this index. PSIM_NOTHING, and the handle of no body, if there is none.
PSIM_API psim_result psim_world_id_of(const psim_world* world, uint32_t index, psim_body_id* id);

/// Place and motion of a body. O(1). PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_body(const psim_world* world, psim_body_id id, psim_body_state* state);

/// Sets the place, metres and radians, also of a disabled body, which refuses numbers out of their ranges.
/// PSIM_ERROR_STALE_ID, PSIM_ERROR_NOT_MOVABLE. A number that is
/// not finite is taken and quarantines the body in the next step. With walls a place beyond them
/// becomes the nearest one within.
PSIM_API psim_result psim_world_set_transform(psim_world* world, psim_body_id id, psim_vec2 position, double angle);

/// Sets the motion, m/s and rad/s. Errors as psim_world_set_transform.
PSIM_API psim_result psim_world_set_velocity(psim_world* world, psim_body_id id, psim_vec2 velocity,
                                             double angular_velocity);

/// Adds impulse / mass to the velocity, N s. Errors as psim_world_set_transform.
PSIM_API psim_result psim_world_apply_impulse(psim_world* world, psim_body_id id, psim_vec2 impulse);

/// N s at a world point, metres: turns the body too. Errors as psim_world_set_transform.
PSIM_API psim_result psim_world_apply_impulse_at(psim_world* world, psim_body_id id, psim_vec2 impulse,
                                                 psim_vec2 point);

/// N m s: turns the body. Errors as psim_world_set_transform.
PSIM_API psim_result psim_world_apply_angular_impulse(psim_world* world, psim_body_id id, double impulse);

/// Pushes a body at its centre of mass, N, until the next step is over, beside all other forces. Forces of several calls
/// add up, and the body wakes. PSIM_ERROR_STALE_ID, PSIM_ERROR_NOT_MOVABLE, PSIM_ERROR_ARGUMENT for a force out of its
/// range.
PSIM_API psim_result psim_world_apply_force(psim_world* world, psim_body_id id, psim_vec2 force);

/// The same at a world point, metres: turns the body too.
PSIM_API psim_result psim_world_apply_force_at(psim_world* world, psim_body_id id, psim_vec2 force, psim_vec2 point);

/// The same with a torque, N m.
PSIM_API psim_result psim_world_apply_torque(psim_world* world, psim_body_id id, double torque);

/// Pushes all dynamic bodies around a point away from it, at once. `pushed` gets how many, unless it is NULL.
/// PSIM_ERROR_ARGUMENT for a number out of its range.
PSIM_API psim_result psim_world_explode(psim_world* world, const psim_explosion* explosion, size_t* pushed);

/// Removes many; `removed` gets how many, unless it is NULL. Those whose id is stale are passed over. Bodies that sleep go
/// together: only what touched them and stays wakes. If memory runs out (PSIM_ERROR_OUT_OF_MEMORY) some stay.
PSIM_API psim_result psim_world_remove_bodies(psim_world* world, const psim_body_id* ids, size_t count,
                                              size_t* removed);

/// Many bodies in one call: what the function for one does with ids[k] and the k-th values, in this order. `changed` gets
/// for how many it was done, unless it is NULL; ids that are stale, bodies that do not move and numbers out of their ranges
/// are passed over. PSIM_ERROR_ARGUMENT if an array is NULL. If memory runs out (PSIM_ERROR_OUT_OF_MEMORY) those that come
/// later are as they were.
/// @{
/// Does what psim_world_set_transform does.
PSIM_API psim_result psim_world_set_transforms(psim_world* world, const psim_body_id* ids, size_t count,
                                               const psim_vec2* positions, const double* angles, size_t* changed);
/// Does what psim_world_set_velocity does.
PSIM_API psim_result psim_world_set_velocities(psim_world* world, const psim_body_id* ids, size_t count,
                                               const psim_vec2* velocities, const double* angular_velocities,
                                               size_t* changed);
/// Does what psim_world_apply_impulse does.
PSIM_API psim_result psim_world_apply_impulses(psim_world* world, const psim_body_id* ids, size_t count,
                                               const psim_vec2* impulses, size_t* changed);
/// Does what psim_world_apply_force does.
PSIM_API psim_result psim_world_apply_forces(psim_world* world, const psim_body_id* ids, size_t count,
                                             const psim_vec2* forces, size_t* changed);
/// Does what psim_world_set_enabled does.
PSIM_API psim_result psim_world_set_enabled_of(psim_world* world, const psim_body_id* ids, size_t count, int32_t on,
                                               size_t* changed);
/// Does what psim_world_set_traits does. The structs lie `stride` bytes apart (sizeof(psim_body_traits) for an array); if one of them
/// has a field that cannot be read, nothing changes.
PSIM_API psim_result psim_world_set_traits_of(psim_world* world, const psim_body_id* ids, size_t count,
                                              const psim_body_traits* traits, size_t stride, size_t* changed);
/// @}

/// Place and motion of many bodies, into states[k] those of ids[k]; of a stale id a state whose id is that of no body.
/// `known` gets how many are there, unless it is NULL. PSIM_ERROR_ARGUMENT if an array is NULL.
PSIM_API psim_result psim_world_states_of(const psim_world* world, const psim_body_id* ids, size_t count,
                                          psim_body_state* states, size_t* known);

/// Where the mass of a body is, metres; of a static body its place. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_centre_of_mass(const psim_world* world, psim_body_id id, psim_vec2* centre);

/// m/s: of the point of a body that is at `point`, metres. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_velocity_at(const psim_world* world, psim_body_id id, psim_vec2 point,
                                            psim_vec2* velocity);

/// The smallest box about all parts of a body, metres. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_bounds_of(const psim_world* world, psim_body_id id, psim_bounds* bounds);

/// The parts of a body in its frame, `*count` of them, with all that each has: as psim_body_desc::parts they make such a
/// body again. `position` is the first point of a part, of a disc its centre, and `angle` is 0; boxes come as polygons.
/// Lines of one part end to end are a chain; of a chain whose segments have surfaces each is a part. `density`, of a dynamic
/// body, is its mass over its area. The parts and their vertices stay until the next call of this function. Not beside
/// another call. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_shapes_of(psim_world* world, psim_body_id id, const psim_shape_part** parts,
                                          size_t* count);

/// The smallest box about one of them, metres. PSIM_ERROR_STALE_ID; PSIM_NOTHING if there is none of this number.
PSIM_API psim_result psim_world_bounds_of_part(const psim_world* world, psim_body_id id, size_t number,
                                               psim_bounds* bounds);

/// Gives a body another description, as psim_world_add_body takes it: another type, shape or place, also of a static body.
/// It keeps its handle and its joints. PSIM_ERROR_STALE_ID, PSIM_ERROR_ARGUMENT; nothing changes then.
PSIM_API psim_result psim_world_set_body(psim_world* world, psim_body_id id, const psim_body_desc* desc);

/// Takes a body out of the simulation for a while, or lets it come back: nothing meets it, finds it or moves it, its joints
/// do nothing, and it costs nothing. It keeps its id, its place and its velocity; psim_world_set_transform and
/// psim_world_set_velocity change those of a moving body meanwhile. PSIM_ERROR_STALE_ID, PSIM_ERROR_NOT_MOVABLE if it is
/// frozen.
PSIM_API psim_result psim_world_set_enabled(psim_world* world, psim_body_id id, int32_t on);

/// 1 if the body takes part in the world, 0 if it is disabled or unknown.
PSIM_API int32_t psim_world_is_enabled(const psim_world* world, psim_body_id id);

/// Fills in what psim_world_set_traits can change of a body. PSIM_ERROR_STALE_ID if the body is gone.
PSIM_API psim_result psim_world_traits(const psim_world* world, psim_body_id id, psim_body_traits* traits);

/// Changes what differs from psim_world_traits, in all parts of the body. A mass that changes alone takes the inertia with
/// it. The body and what it touches wake. PSIM_ERROR_STALE_ID; PSIM_ERROR_ARGUMENT if the body is frozen, a number out of
/// its range, or a static body's sensor flag another one: then nothing changes.
PSIM_API psim_result psim_world_set_traits(psim_world* world, psim_body_id id, const psim_body_traits* traits);

/// How many parts a body has: of several shapes, segments of a chain with surfaces of its own, in a kinematic body each
/// segment; else 1. 0 if it is unknown.
PSIM_API uint32_t psim_world_part_count(const psim_world* world, psim_body_id id);

/// Fills in what psim_world_set_part_traits can change of a part. PSIM_ERROR_STALE_ID if the body is gone,
/// PSIM_ERROR_ARGUMENT if it has no such part.
PSIM_API psim_result psim_world_part_traits(const psim_world* world, psim_body_id id, uint32_t part,
                                            psim_part_traits* traits);

/// Changes a part, as psim_world_set_traits does all of them. PSIM_ERROR_STALE_ID; PSIM_ERROR_ARGUMENT as there, and of the
/// sensors among the parts of a static body: then nothing changes.
PSIM_API psim_result psim_world_set_part_traits(psim_world* world, psim_body_id id, uint32_t part,
                                                const psim_part_traits* traits);

/// 64 bits that the caller keeps with a body; 0 of one that has none, or is not there.
PSIM_API uint64_t psim_world_user_data(const psim_world* world, psim_body_id id);

/// Changes them. Wakes nobody, and changes no result. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_set_user_data(psim_world* world, psim_body_id id, uint64_t value);

/// 1 if the body takes part in the steps; 0 for static, sleeping, frozen and unknown ones.
PSIM_API int32_t psim_world_is_awake(const psim_world* world, psim_body_id id);

/// Wakes a body that sleeps, and what is joined to it. PSIM_ERROR_STALE_ID.
PSIM_API psim_result psim_world_wake(psim_world* world, psim_body_id id);

/// Why a body is awake, in one line, or that it is not. Returns the length of the whole line. Not beside another
/// call.
PSIM_API size_t psim_world_why_awake(const psim_world* world, psim_body_id id, char* buffer, size_t capacity);

/// All living bodies; 0 for NULL.
PSIM_API size_t psim_world_body_count(const psim_world* world);

/// Counts the enabled bodies that are dynamic or kinematic; 0 for NULL.
PSIM_API size_t psim_world_dynamic_count(const psim_world* world);

/// Counts the enabled bodies that are static; 0 for NULL.
PSIM_API size_t psim_world_static_count(const psim_world* world);

/// Of psim_world_dynamic_count, those that are no discs.
PSIM_API size_t psim_world_shape_count(const psim_world* world);

/// Bodies that left an open world so far; 0 for NULL.
PSIM_API uint64_t psim_world_escaped_total(const psim_world* world);

#ifdef __cplusplus
}
#endif
