/// @file
/// C API: contacts that the caller decides, and parts of bodies one by one.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A contact that is new: two parts, of which one asks (psim_body_desc.pre_solve), have come near each other and may
/// touch in this step. The members from `enabled` on may be changed; numbers out of their ranges change nothing.
typedef struct psim_new_contact {
  psim_body_id a;  ///< a.index < b.index
  psim_body_id b;  ///< psim_no_body() for a wall of the world
  /// The number of the part, or of the segment in a chain with surfaces of its own; else 0. In a kinematic body each
  /// segment counts.
  uint32_t part_a;
  uint32_t part_b;            ///< likewise; of a wall 0
  psim_vec2 point;            ///< metres: midway between the two surfaces
  psim_vec2 normal;           ///< of length 1, from a to b
  double separation;          ///< metres: between the surfaces along the normal, negative in overlap
  double speed;               ///< m/s: of approach along the normal there; negative: they part
  int32_t enabled;            ///< flag: else the parts go through each other
  int32_t reserved;           ///< 0
  double friction;            ///< of the two together, 0..1000
  double restitution;         ///< likewise, 0..1
  double tangent_speed;       ///< m/s: the sum of both, as in psim_surface
  double rolling_resistance;  ///< of the two together, 0..1
} psim_new_contact;

/// Gets all new contacts of a step, ordered by a, b, part_a, part_b, on the thread that steps, and changes what it wants
/// to. It may call functions that tell of one body, none that change the world, and must not throw.
typedef void (*psim_pre_solve)(void* user, psim_new_contact* contacts, size_t count);

/// psim_world_part_traits reads these of a part of a body, and psim_world_set_part_traits changes them at any time.
typedef struct psim_part_traits {
  uint32_t struct_size;  ///< set by psim_part_traits_init
  psim_filter filter;    ///< who it collides with
  psim_surface surface;  ///< how it bounces and rubs
  psim_vec2 one_way;     ///< as in psim_body_desc
  int32_t sensor;        ///< flag: as in psim_shape_part; a static body does not change it
  int32_t pre_solve;     ///< flag: as in psim_body_desc
  uint64_t user_data;    ///< whatever the caller likes; of a body of one part, psim_world_user_data
} psim_part_traits;

/// Sets the defaults.
static inline void psim_part_traits_init(psim_part_traits* traits) {
  psim_init(traits, PSIM_STRUCT_PART_TRAITS, (uint32_t)sizeof *traits);
}

#ifdef __cplusplus
}
#endif
