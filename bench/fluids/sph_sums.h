// Sums over neighbours of the smoothed-particle solver, in floats, eight neighbours at once.
//
// The kernel is Wendland's C2 in two dimensions (Wendland 1995; Dehnen and Aly 2012), q = r / h, t = 1 - q / 2:
//   W = 7 / (4 pi h^2) t^4 (2 q + 1),   grad W = -F (r_i - r_j),   F = 35 / (4 pi h^4) t^3,   for q < 2.
// Terms with (r . grad W) / r^2, as in viscosity and diffusion, are -F, so no sum divides by r.
//
// Each function reads grid.columns and writes what it is named after, one value a particle. O(particles x neighbours).
#pragma once

#include "sph_grid.h"

namespace psim::fluids {

struct SphKernel {
  explicit SphKernel(double reach);
  float half_over_h;  ///< t = 1 - r * half_over_h
  float w;            ///< 7 / (4 pi h^2)
  float f;            ///< 35 / (4 pi h^4)
};

/// Of the equations below: constants of the flow and of the method.
struct SphConstants {
  SphKernel kernel;
  float mass;                  ///< kg, of a particle
  float sound;                 ///< m/s
  float gravity_x, gravity_y;  ///< m/s^2
  float viscosity;             ///< m^2/s
  float artificial;            ///< m^2/s: alpha h c0
  float diffusion;             ///< m^2/s: delta h c0
  float background;            ///< N/m: pressure that moves particles and not the fluid
};

/// d strain / dt = -(1 + strain) div v + 2 delta h c0 sum F V (strain_j - strain_i - that of water at rest): continuity with the
/// diffusion of Molteni and Colagrossi (2009) for what differs from rest (Fourtakas et al. 2019).
void sum_strain_rates(const SphGrid& grid, const SphConstants& k, std::vector<float>& rates);

/// density / kDensity - 1 = m / kDensity sum W - 1.
void sum_strains(const SphGrid& grid, const SphConstants& k, std::vector<float>& strains);

/// Pressure of walls, so that none flows in (Adami, Hu and Adams 2012, equation 27); not below zero.
void sum_wall_pressures(SphGrid& grid, const SphConstants& k);

/// dv/dt by pressure, by viscosity (Morris, Fox and Zhu 1997) and by artificial viscosity (Monaghan 1992); walls slip.
void sum_forces(const SphGrid& grid, const SphConstants& k, std::vector<SphParticle>& particles);

/// The same with transport velocity (Adami, Hu and Adams 2013, equations 8 and 13), without walls and artificial viscosity.
void sum_transport_forces(const SphGrid& grid, const SphConstants& k, std::vector<SphParticle>& particles);

}  // namespace psim::fluids
