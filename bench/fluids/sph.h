// A reference solver of weakly compressible smoothed particles, to measure psim's fluids against. Sums in sph_sums.h.
//
// Pressure is sound^2 (density - kDensity). Two schemes:
//   free surfaces:  density by continuity with diffusion (delta-SPH: Molteni and Colagrossi 2009; Antuono et al. 2012),
//                   walls of dummy particles (Adami, Hu and Adams 2012)
//   periodic flows: density by summation, particles move by the transport velocity (Adami, Hu and Adams 2013)
// A step is velocity Verlet (kick, drift, kick) with one sum over neighbours for density and one for forces. It runs on
// the calling thread.
#pragma once

#include <vector>

#include "flow.h"
#include "sph_grid.h"
#include "sph_sums.h"

namespace psim::fluids {

struct SphSettings {
  double reach = 4;      ///< of the kernel, 2 h, in spacings: 50 neighbours
  double sound = 10;     ///< speed of sound over the fastest flow: 1 % of compression
  double courant = 0.6;  ///< a step over h / (sound + speed)
  double alpha = 0.01;   ///< artificial viscosity of flows with a free surface
  double delta = 0.1;    ///< diffusion of density, likewise
};

class Sph {
 public:
  /// Throws std::runtime_error on a processor without AVX2, for which the sums are compiled.
  Sph(const Flow& flow, const SphSettings& settings);

  /// The longest stable step, seconds: of sound, of viscosity (0.125 h^2 / nu) and of gravity (0.25 sqrt(h / g)).
  double longest_step() const { return longest_step_; }
  void step(double dt);
  /// The cheapest sum that there is, of densities, for all particles: what methods pay for each of their iterations.
  void sum_densities(std::vector<float>& strains) const;
  /// Particles in the order of Flow::places.
  void look(std::vector<Particle>& out) const;

 private:
  void move(double dt);
  void find_volumes();
  void find_pressures();
  void find_forces();

  Bounds bounds_;
  bool transport_;
  SphGrid grid_;
  SphConstants constants_;
  double longest_step_ = 0;
  std::vector<SphParticle> particles_;
  std::vector<float> rates_;
};

}  // namespace psim::fluids
