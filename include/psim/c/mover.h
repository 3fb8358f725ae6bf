/// @file
/// C API: characters that walk through a world (docs/queries-events.md). psim/mover.h says what they do.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A character. Made by psim_mover_create, freed by psim_mover_destroy. It belongs to no world.
typedef struct psim_mover psim_mover;

/// Describes a mover: an upright capsule.
typedef struct psim_mover_desc {
  uint32_t struct_size;             ///< set by psim_mover_desc_init
  int32_t reserved;                 ///< 0
  double radius;                    ///< metres, 1e-6 to 1e3: of the capsule; default 0.3
  double half_height;               ///< metres, 0 to 1e3: from its middle to the centres of its ends; default 0.6
  psim_vec2 up;                     ///< direction of any length: the capsule stands along it; default (0, 1)
  double slope_limit;               ///< radians, 0 to 1.5: ground is no steeper; default 0.873
  double step_height;               ///< metres, 0 to 1e3: it climbs steps no higher; default 0.3
  double skin;                      ///< metres, above 0, at most the radius: the distance that it keeps; default 0.01
  double push_force;                ///< N, 0 to 1e12: it pushes dynamic bodies with no more; default 0
  const psim_query_filter* filter;  ///< what it meets, copied; default NULL: all but sensors
} psim_mover_desc;

/// Where a mover is and what it stands on.
typedef struct psim_mover_state {
  uint32_t struct_size;       ///< set by psim_mover_state_init
  int32_t on_ground;          ///< flag: it stands; else what follows about the ground is 0
  psim_vec2 position;         ///< metres: the middle of the capsule
  psim_vec2 velocity;         ///< m/s: what is left of the last move's velocity
  psim_body_id ground;        ///< that it stands on
  psim_vec2 ground_point;     ///< metres: where it touches
  psim_vec2 ground_normal;    ///< of the surface
  psim_vec2 ground_velocity;  ///< m/s: of the surface at the point
  double squeezed;            ///< metres: how deep it is still in something after the last move; 0: it is free
} psim_mover_state;

/// Tells of one body that a mover met in a move.
typedef struct psim_mover_touch {
  psim_body_id body;  ///< that it met
  psim_vec2 point;    ///< metres
  psim_vec2 normal;   ///< of the body's surface
} psim_mover_touch;

/// Sets the defaults.
static inline void psim_mover_desc_init(psim_mover_desc* desc) {
  psim_init(desc, PSIM_STRUCT_MOVER_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_mover_state_init(psim_mover_state* state) {
  psim_init(state, PSIM_STRUCT_MOVER_STATE, (uint32_t)sizeof *state);
}

/// Makes a mover at a place, metres: of the middle of the capsule. On failure `*mover` is NULL and `error` has one line.
PSIM_API psim_result psim_mover_create(const psim_mover_desc* desc, psim_vec2 position, psim_mover** mover, char* error,
                                       size_t capacity);

/// NULL is allowed.
PSIM_API void psim_mover_destroy(psim_mover* mover);

/// Makes a mover like another one, of which every move has the same bits: for going back some frames.
PSIM_API psim_result psim_mover_copy(const psim_mover* from, psim_mover* to);

/// One move of `dt` seconds (above 0, at most 10) at `velocity`, m/s, as seen from what it stands on: after each step of
/// the world. The pushes go into the world's recording, if there is one. Not beside another call.
PSIM_API psim_result psim_mover_move(psim_mover* mover, psim_world* world, psim_vec2 velocity, double dt);

/// Puts it elsewhere, metres: at rest, on no ground.
PSIM_API psim_result psim_mover_set_position(psim_mover* mover, psim_vec2 position);

/// Changes what it is, say to duck; it stays where its middle is.
PSIM_API psim_result psim_mover_set_desc(psim_mover* mover, const psim_mover_desc* desc);

/// Where it is and what it stands on.
PSIM_API psim_result psim_mover_get_state(const psim_mover* mover, psim_mover_state* state);

/// Tells what it met in the last move, each body once: `*count` of them, 16 at most, as many as fit written into `touches`.
PSIM_API psim_result psim_mover_touches(const psim_mover* mover, psim_mover_touch* touches, size_t capacity,
                                        size_t* count);

#ifdef __cplusplus
}
#endif
