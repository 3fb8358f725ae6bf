/// @file
/// C API: fluids, water or another liquid as particles that carry mass and momentum.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// This says what a fluid is made of. A particle has the mass density * spacing^2.
typedef struct psim_fluid_desc {
  uint32_t struct_size;  ///< set by psim_fluid_desc_init
  int32_t reserved;      ///< 0
  double spacing;        ///< metres, 1e-3 to 1e3; no default
  double density;        ///< kg/m^2; default 1000
  double viscosity;      ///< m^2/s, kinematic; default 0
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
} psim_fluid_report;

/// Sets the defaults.
static inline void psim_fluid_desc_init(psim_fluid_desc* desc) {
  psim_init(desc, PSIM_STRUCT_FLUID_DESC, (uint32_t)sizeof *desc);
}

/// Sets the defaults.
static inline void psim_fluid_report_init(psim_fluid_report* report) {
  psim_init(report, PSIM_STRUCT_FLUID_REPORT, (uint32_t)sizeof *report);
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

#ifdef __cplusplus
}
#endif
