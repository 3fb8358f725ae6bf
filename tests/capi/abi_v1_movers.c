/* The layout of the structs of casts and movers, as abi_v1.c has that of the others. */
#include <psim.h>

#define NAME_OF_LINE(line) pinned_##line
#define NAME_AT(line) NAME_OF_LINE(line)
#define HOLDS(condition) typedef char NAME_AT(__LINE__)[(condition) ? 1 : -1]
#define SIZE(type, bytes) HOLDS(sizeof(type) == (bytes))
#define AT(type, field, bytes) HOLDS(offsetof(type, field) == (bytes))

/* clang-format off */
SIZE(psim_ray, 32);
  AT(psim_ray, from, 0);
  AT(psim_ray, to, 16);
SIZE(psim_shape_cast_hit, 48);
  AT(psim_shape_cast_hit, body, 0);
  AT(psim_shape_cast_hit, point, 8);
  AT(psim_shape_cast_hit, normal, 24);
  AT(psim_shape_cast_hit, fraction, 40);
SIZE(psim_near_hit, 56);
  AT(psim_near_hit, body, 0);
  AT(psim_near_hit, point, 8);
  AT(psim_near_hit, normal, 24);
  AT(psim_near_hit, distance, 40);
  AT(psim_near_hit, one_way, 48);
  AT(psim_near_hit, reserved, 52);
SIZE(psim_mover_desc, 80);
  AT(psim_mover_desc, struct_size, 0);
  AT(psim_mover_desc, reserved, 4);
  AT(psim_mover_desc, radius, 8);
  AT(psim_mover_desc, half_height, 16);
  AT(psim_mover_desc, up, 24);
  AT(psim_mover_desc, slope_limit, 40);
  AT(psim_mover_desc, step_height, 48);
  AT(psim_mover_desc, skin, 56);
  AT(psim_mover_desc, push_force, 64);
  AT(psim_mover_desc, filter, 72);
SIZE(psim_mover_state, 104);
  AT(psim_mover_state, struct_size, 0);
  AT(psim_mover_state, on_ground, 4);
  AT(psim_mover_state, position, 8);
  AT(psim_mover_state, velocity, 24);
  AT(psim_mover_state, ground, 40);
  AT(psim_mover_state, ground_point, 48);
  AT(psim_mover_state, ground_normal, 64);
  AT(psim_mover_state, ground_velocity, 80);
  AT(psim_mover_state, squeezed, 96);
SIZE(psim_mover_touch, 40);
  AT(psim_mover_touch, body, 0);
  AT(psim_mover_touch, point, 8);
  AT(psim_mover_touch, normal, 24);
/* clang-format on */
