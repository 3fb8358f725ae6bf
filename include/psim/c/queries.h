/// @file
/// C API: what is where, and what happened in a step (docs/queries-events.md).
///
/// A filter of NULL asks all bodies but sensors. Where a question has several answers they go into an
/// array of the caller: as many as fit its capacity; `*count` is how many there are. Numbers that are
/// not finite and impossible shapes find nothing. Any number of threads may ask at once meanwhile
/// nobody changes the world.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where a ray enters a body.
typedef struct psim_ray_hit {
  psim_body_id body;  ///< that it enters
  psim_vec2 point;    ///< metres
  psim_vec2 normal;   ///< of the body's surface there; zero where the ray starts inside
  double fraction;    ///< 0 to 1 of the way
} psim_ray_hit;

/// A ray of psim_world_ray_cast_batch.
typedef struct psim_ray {
  psim_vec2 from;  ///< metres
  psim_vec2 to;    ///< metres
} psim_ray;

/// Where a shape that moves meets a body.
typedef struct psim_shape_cast_hit {
  psim_body_id body;  ///< that it meets
  psim_vec2 point;    ///< metres, on the body's surface: the middle of what touches; `from` if it overlaps at the start
  psim_vec2 normal;   ///< of the body's surface there; zero if it overlaps at the start
  double fraction;    ///< 0 to 1 of the way and of the rotation
} psim_shape_cast_hit;

/// Part of a body near a shape.
typedef struct psim_near_hit {
  psim_body_id body;  ///< whose part it is
  psim_vec2 point;    ///< metres, on its surface: the nearest, or the middle of what is nearest
  psim_vec2 normal;   ///< of length 1, from there to the shape: the shortest way out if they overlap
  double distance;    ///< metres; negative: how deep they overlap
  int32_t one_way;    ///< flag: the part is solid from one side alone
  uint32_t part;      ///< which part of the body, as in psim_parts
} psim_near_hit;

/// The nearest point of a body.
typedef struct psim_closest_hit {
  psim_body_id body;  ///< the nearest
  psim_vec2 point;    ///< metres, on the surface; the question's own point where it is inside
  double distance;    ///< metres, 0 inside
} psim_closest_hit;

/// Two bodies began or ceased to touch.
typedef struct psim_touch_event {
  psim_body_id a;  ///< a.index < b.index; of a sensor's events the sensor
  psim_body_id b;  ///< the other; no body for a wall of the world
} psim_touch_event;

/// Where two bodies touch.
typedef struct psim_touch_point {
  psim_vec2 point;   ///< metres: where they press or overlap most
  psim_vec2 normal;  ///< of length 1, from a to b
} psim_touch_point;

/// A body that moved in a step.
typedef struct psim_move_event {
  psim_body_id body;    ///< dynamic or kinematic
  psim_vec2 position;   ///< metres: of its origin
  double angle;         ///< radians
  int32_t fell_asleep;  ///< flag: after the step
  int32_t reserved;     ///< 0
} psim_move_event;

/// Two bodies hit each other.
typedef struct psim_hit_event {
  psim_body_id a;    ///< a.index < b.index
  psim_body_id b;    ///< no body for a wall of the world
  psim_vec2 point;   ///< metres
  psim_vec2 normal;  ///< from a to b
  double speed;      ///< m/s, of approach along the normal
} psim_hit_event;

/// A joint was loaded with more than it bears, and is gone.
typedef struct psim_joint_break {
  psim_joint_id joint;  ///< its handle, of nothing any more
  psim_body_id a;       ///< as described
  psim_body_id b;       ///< as described
  psim_vec2 point;      ///< metres: the anchor at b
  psim_vec2 force;      ///< N on b, the mean of the step
  double torque;        ///< N m on b, the mean of the step
  uint64_t user_data;   ///< of the description
} psim_joint_break;

/// One point in which two bodies touched at the end of the last step. Two shapes that touch along an edge
/// have two, one after the other.
typedef struct psim_contact {
  psim_body_id a;     ///< a.index < b.index
  psim_body_id b;     ///< no body for a wall of the world
  psim_vec2 point;    ///< metres: midway between the two surfaces
  psim_vec2 normal;   ///< of length 1, from a to b
  double separation;  ///< metres along the normal, negative in overlap
  double impulse;     ///< N s, >= 0: what the last substep put on b along the normal, times the substeps
  double friction;    ///< N s: likewise along (-normal.y, normal.x)
} psim_contact;

/// Which parts of two bodies touch: as in psim_world_part_traits; which segment of a chain with surfaces of its own; else
/// 0.
typedef struct psim_parts {
  uint32_t a;  ///< of the first body
  uint32_t b;  ///< of the second; of a wall of the world 0
} psim_parts;

/// No strip, or no colour.
#define PSIM_NO_GROUP 0xFFFFFFFFu

/// With which others a contact was solved.
typedef struct psim_contact_group {
  uint32_t strip;   ///< of the lists that it was found in, as psim_world_strips; PSIM_NO_GROUP among sleepers
  uint32_t colour;  ///< in that strip: no two contacts of one colour share a dynamic body; PSIM_NO_GROUP: solved by
                    ///< itself, or not known: after psim_world_restore until the next step and while a governor
                    ///< spreads a step over frames
} psim_contact_group;

/// A particle of a fluid entered or left a sensor.
typedef struct psim_fluid_event {
  psim_body_id sensor;  ///< the body
  uint32_t part;        ///< which part of it
  uint32_t fluid;       ///< what the particle is of
  uint32_t particle;    ///< psim_fluid_particle.id
} psim_fluid_event;

/// Of the last step, each list ordered by a, then b.
typedef struct psim_events {
  uint32_t struct_size;                  ///< set by psim_events_init
  uint32_t reserved;                     ///< 0
  const psim_touch_event* begin;         ///< touch now and did not before
  size_t begin_count;                    ///< how many
  const psim_touch_event* end;           ///< touched and do no more
  size_t end_count;                      ///< how many
  const psim_hit_event* hits;            ///< faster than hit_speed
  size_t hit_count;                      ///< how many
  const psim_touch_event* sensor_begin;  ///< a is the sensor, b entered it
  size_t sensor_begin_count;             ///< how many
  const psim_touch_event* sensor_end;    ///< a is the sensor, b left it
  size_t sensor_end_count;               ///< how many
  const psim_joint_break* breaks;        ///< joints that broke, by index; always told
  size_t break_count;                    ///< how many
  const psim_touch_point* begin_points;  ///< of each event in `begin`
  size_t begin_point_count;              ///< as many
  const psim_body_id* fell_asleep;       ///< at the end of the step
  size_t fell_asleep_count;              ///< how many
  const psim_body_id* woke;              ///< since the end of the step before; also by what the host did
  size_t woke_count;                     ///< how many
  const psim_move_event* moves;          ///< all that took part in the step and are there, asleep or not
  size_t move_count;                     ///< how many
  const double* hit_impulses;            ///< N s, of each event in `hits`: that changed the approach as it did
  size_t hit_impulse_count;              ///< as many
  const psim_parts* hit_parts;           ///< of each event in `hits`
  size_t hit_part_count;                 ///< as many
  const uint32_t* sensor_begin_parts;    ///< of each event in `sensor_begin`: which part of a feels b
  size_t sensor_begin_part_count;        ///< as many
  const uint32_t* sensor_end_parts;      ///< of each event in `sensor_end`
  size_t sensor_end_part_count;          ///< as many
  const psim_fluid_event* fluid_begin;   ///< particles that are in a sensor and were not: by sensor, part and particle
  size_t fluid_begin_count;              ///< how many
  const psim_fluid_event* fluid_end;     ///< particles that were in a sensor and are not, or are gone
  size_t fluid_end_count;                ///< how many
} psim_events;

/// Sets the defaults.
static inline void psim_events_init(psim_events* events) {
  psim_init(events, PSIM_STRUCT_EVENTS, (uint32_t)sizeof *events);
}

/// The first body that the way from `from` to `to`, metres, enters. PSIM_NOTHING.
PSIM_API psim_result psim_world_ray_cast(const psim_world* world, psim_vec2 from, psim_vec2 to,
                                         const psim_query_filter* filter, psim_ray_hit* hit);

/// The same, and which part of the body it enters, as in psim_parts.
PSIM_API psim_result psim_world_ray_cast_part(const psim_world* world, psim_vec2 from, psim_vec2 to,
                                              const psim_query_filter* filter, psim_ray_hit* hit, uint32_t* part);

/// All of them, nearest first, then by id.
PSIM_API psim_result psim_world_ray_cast_all(const psim_world* world, psim_vec2 from, psim_vec2 to,
                                             const psim_query_filter* filter, psim_ray_hit* hits, size_t capacity,
                                             size_t* count);

/// The first hits of many rays, on all threads of the world or the host's job system: hits[k] is what psim_world_ray_cast
/// says to rays[k], or a hit of no body (index 0xFFFFFFFF). `*met`: how many rays met a body; may be NULL. Not beside
/// another call.
PSIM_API psim_result psim_world_ray_cast_batch(psim_world* world, const psim_ray* rays, psim_ray_hit* hits,
                                               size_t count, const psim_query_filter* filter, size_t* met);

/// The first body that a convex shape meets on its way from `from`, metres, turned by `angle`: it goes `translation`,
/// metres, and turns by `rotation`, radians, at most 1,000 either way, about its own origin meanwhile. PSIM_NOTHING.
PSIM_API psim_result psim_world_shape_cast(const psim_world* world, const psim_shape* shape, psim_vec2 from,
                                           double angle, psim_vec2 translation, double rotation,
                                           const psim_query_filter* filter, psim_shape_cast_hit* hit);

/// The same, and which part of the body it meets, as in psim_parts.
PSIM_API psim_result psim_world_shape_cast_part(const psim_world* world, const psim_shape* shape, psim_vec2 from,
                                                double angle, psim_vec2 translation, double rotation,
                                                const psim_query_filter* filter, psim_shape_cast_hit* hit,
                                                uint32_t* part);

/// Finds what lies within `reach` metres of a shape placed at (position, angle), piece by piece, the nearest first.
PSIM_API psim_result psim_world_nearby(const psim_world* world, const psim_shape* shape, psim_vec2 position,
                                       double angle, double reach, const psim_query_filter* filter, psim_near_hit* hits,
                                       size_t capacity, size_t* count);

/// Bodies that overlap a shape placed at (position, angle), by id.
PSIM_API psim_result psim_world_overlap(const psim_world* world, const psim_shape* shape, psim_vec2 position,
                                        double angle, const psim_query_filter* filter, psim_body_id* ids,
                                        size_t capacity, size_t* count);

/// Bodies of which some part lies in the rectangle, by id.
PSIM_API psim_result psim_world_in_region(const psim_world* world, psim_bounds region, const psim_query_filter* filter,
                                          psim_body_id* ids, size_t capacity, size_t* count);

/// The body nearest to a point, within `reach` metres; of several the least id. PSIM_NOTHING.
PSIM_API psim_result psim_world_closest(const psim_world* world, psim_vec2 point, double reach,
                                        const psim_query_filter* filter, psim_closest_hit* hit);

/// The same, and which part of the body is the nearest, as in psim_parts.
PSIM_API psim_result psim_world_closest_part(const psim_world* world, psim_vec2 point, double reach,
                                             const psim_query_filter* filter, psim_closest_hit* hit, uint32_t* part);

/// Chooses what steps tell; nothing at first.
PSIM_API psim_result psim_world_set_event_options(psim_world* world, const psim_event_options* options);

/// What the last step told. The lists are copied: they stay until the next call of this function.
/// Not beside another call.
PSIM_API psim_result psim_world_events(psim_world* world, psim_events* events);

/// What touches, as of the end of the last step: every contact that carries an impulse or overlaps, with walls and
/// static bodies too, `*count` of them, ordered by a, then b, then normal, then point. An impulse is what the
/// contact carried in the last substep, times the substeps. Sleeping bodies' contacts are told as they were when
/// the bodies fell asleep. The list stays until the next call of this function. Not beside another call.
PSIM_API psim_result psim_world_contacts(psim_world* world, const psim_contact** contacts, size_t* count);

/// Strip and colour of the contacts that psim_world_contacts gave last, `*count` of them in the same order. The list
/// stays until the next call of that function.
PSIM_API psim_result psim_world_contact_groups(psim_world* world, const psim_contact_group** groups, size_t* count);

/// Which parts touch in each of the contacts that psim_world_contacts told of last, in the same order. The array is the
/// world's, until the next call of psim_world_contacts.
PSIM_API psim_result psim_world_contact_parts(psim_world* world, const psim_parts** parts, size_t* count);

/// By body index, for `*count` of them: the strip that the body lay in when the last step's lists were made, some rows
/// of the broad phase's cells, or all large bodies: a unit of parallel work. PSIM_NO_GROUP for who is in no list:
/// static, sleeping, frozen, new, gone. The list stays until the next call of this function or one that changes the
/// world. Not beside another call.
PSIM_API psim_result psim_world_strips(psim_world* world, const uint32_t** strips, size_t* count);

#ifdef __cplusplus
}
#endif
