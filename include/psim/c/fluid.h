/// @file
/// C API: fluids, water or another liquid as particles that carry mass and momentum.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// This says what a fluid is made of. A particle has the mass density * spacing^2.
typedef struct psim_fluid_desc {
  uint32_t struct_size;    ///< set by psim_fluid_desc_init
  int32_t reserved;        ///< 0
  double spacing;          ///< metres, 1e-3 to 1e3; no default
  double density;          ///< kg/m^2; default 1000
  double viscosity;        ///< m^2/s, kinematic; default 0
  double surface_tension;  ///< N/m, 0 to 1e6; default 0
} psim_fluid_desc;

/// A particle.
typedef struct psim_fluid_particle {
  uint32_t id;         ///< particles count from 0 in the order in which they were added
  uint32_t fluid;      ///< what it is a particle of
  psim_vec2 position;  ///< metres
  psim_vec2 velocity;  ///< m/s
  double density;      ///< kg/m^2, where the particle is, as of the last step
  double pressure;     ///< N/m, likewise; 0 before the first step
} psim_fluid_particle;

/// Sums over all particles of a world, and how well the last step went.
typedef struct psim_fluid_report {
  uint32_t struct_size;       ///< set by psim_fluid_report_init
  uint32_t iterations;        ///< of the last step's solvers for pressure and density together
  uint64_t particles;         ///< of all fluids
  double kinetic;             ///< J
  double density_error_mean;  ///< of the cells within the fluid, relative to the density that they should have
  double density_error_max;   ///< likewise, the largest
  uint64_t emitted;           ///< particles that emitters have let out since the world was made
  uint64_t drained;           ///< particles that drains have removed since then
  uint64_t withheld;          ///< particles that emitters could not let out: the world was full or out of memory
} psim_fluid_report;

/// No emitter.
#define PSIM_NO_EMITTER 0xFFFFFFFFu
/// No drain.
#define PSIM_NO_DRAIN 0xFFFFFFFFu
/// No fluid; where a call asks for one: all of them.
#define PSIM_NO_FLUID 0xFFFFFFFFu

/// A fluid flows out of a segment at right angles to it: its length times its speed, whatever the steps are.
typedef struct psim_emitter_desc {
  uint32_t struct_size;  ///< set by psim_emitter_desc_init
  uint32_t fluid;        ///< what flows; default 0
  psim_vec2 from;        ///< metres, inside the world's bounds
  psim_vec2 to;          ///< metres, inside the bounds, elsewhere than `from`
  double speed;          ///< m/s to the left of who looks from `from` to `to`; below 0 to the right; default 0
  double start;          ///< seconds after it was added, >= 0: it opens; default 0
  double end;            ///< seconds after it was added, >= start: it closes; default infinity
  uint64_t limit;        ///< it closes after so many particles; default 2^64 - 1
} psim_emitter_desc;

/// This says how much of a fluid is within an area.
typedef struct psim_fluid_amount {
  uint64_t particles;       ///< number
  double mass;              ///< kg
  psim_vec2 mean_velocity;  ///< m/s: momentum over mass; 0 where there is nothing
} psim_fluid_amount;

/// Sets the defaults.
static inline void psim_fluid_desc_init(psim_fluid_desc* desc) {
  psim_init(desc, PSIM_STRUCT_FLUID_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_fluid_report_init(psim_fluid_report* report) {
  psim_init(report, PSIM_STRUCT_FLUID_REPORT, (uint32_t)sizeof *report);
}

/// Sets the defaults.
static inline void psim_emitter_desc_init(psim_emitter_desc* desc) {
  psim_init(desc, PSIM_STRUCT_EMITTER_DESC, (uint32_t)sizeof *desc);
}

/// Adds a fluid without particles; `fluid` (may be NULL) is its number, from 0. The first one decides how fine the grid
/// is on which all are solved: none of a larger spacing can be added later.
PSIM_API psim_result psim_world_add_fluid(psim_world* world, const psim_fluid_desc* desc, uint32_t* fluid);

/// Adds `count` particles at these places, inside the world's bounds, all or none. `velocities` may be NULL: at rest.
PSIM_API psim_result psim_world_add_particles(psim_world* world, uint32_t fluid, const psim_vec2* positions,
                                              const psim_vec2* velocities, size_t count);

/// All particles by id, `*count` of them. The list is a copy: it stays until the next call of this function. Not beside
/// another call.
PSIM_API psim_result psim_world_fluid_particles(psim_world* world, const psim_fluid_particle** particles,
                                                size_t* count);

/// Sums over all particles.
PSIM_API psim_result psim_world_fluid_report(const psim_world* world, psim_fluid_report* report);

/// Lets a fluid out of a segment from the end of the next step on; `emitter` (may be NULL) is its number, from 0.
PSIM_API psim_result psim_world_add_emitter(psim_world* world, const psim_emitter_desc* desc, uint32_t* emitter);

/// The particles that it let out stay.
PSIM_API psim_result psim_world_remove_emitter(psim_world* world, uint32_t emitter);

/// Lets the fluid out at another speed, m/s; 0 stops it.
PSIM_API psim_result psim_world_set_emitter_speed(psim_world* world, uint32_t emitter, double speed);

/// Removes the particles within a rectangle at the end of each step; `drain` (may be NULL) is its number, from 0.
PSIM_API psim_result psim_world_add_drain(psim_world* world, psim_bounds region, uint32_t* drain);

/// Removes a drain.
PSIM_API psim_result psim_world_remove_drain(psim_world* world, uint32_t drain);

/// The particles of a fluid, or of all for PSIM_NO_FLUID, within a rectangle.
PSIM_API psim_result psim_world_fluid_in(const psim_world* world, psim_bounds region, uint32_t fluid,
                                         psim_fluid_amount* amount);

/// The particles of a fluid, or of all for PSIM_NO_FLUID, whose middle is within the sensor shapes of a body.
PSIM_API psim_result psim_world_fluid_in_sensor(const psim_world* world, psim_body_id body, uint32_t fluid,
                                                psim_fluid_amount* amount);

/// Returns what the pressure of fluids did to a body in the last step: the mean force, N, and the torque about its centre of mass, N m.
/// Both are 0 where it met none.
PSIM_API psim_result psim_world_fluid_load(const psim_world* world, psim_body_id body, psim_vec2* force,
                                           double* torque);

#ifdef __cplusplus
}
#endif
