// The fluids of a world: particles that carry mass and momentum, and a grid on which pressure is found.
//
// A step:
//   move        particles go on as they move, and are sorted by tiles of 16 x 16 cells; a cell is two spacings wide
//   scatter     mass, momentum and volume of particles, at faces and in the middles of cells
//   equations   of the cells that are full: pressure, so that the velocity has no divergence; and a displacement, so that
//               the density is even
//   gather      particles take what the grid's velocity gained, and the displacement
#pragma once

#include <cstdint>
#include <vector>

#include "fluid/fluid_equations.h"
#include "fluid/fluid_particles.h"
#include "fluid/fluid_solver.h"

namespace psim {

/// What a fluid is made of.
struct FluidKind {
  double spacing = 0;    ///< m
  double density = 0;    ///< kg/m^2
  double viscosity = 0;  ///< m^2/s
};

struct FluidCounts {
  std::size_t particles = 0;
  double kinetic = 0;                                    ///< J
  double density_error_mean = 0, density_error_max = 0;  ///< of the cells within the fluid, relative
  std::uint32_t iterations = 0;                          ///< of the last step, for pressure and for density
};

class Fluids {
 public:
  Fluids(MemoryMeter& meter, const kernels::KernelTable& kernels, WorkerPool& pool)
      : kernels_(kernels), pool_(pool), particles_(meter), solver_(meter, kernels, pool), old_pressure_(meter) {}

  void begin(const FluidSpace& space) { space_ = space; }
  std::uint32_t add_kind(const FluidKind& kind);
  void add(std::uint32_t fluid, Vec2 place, Vec2 velocity);
  /// Moves all fluids by dt seconds. `gravity`: m/s^2.
  void step(double dt, Vec2 gravity);

  std::size_t size() const { return particles_.size(); }
  FluidCounts counts() const;
  struct Seen {
    std::uint32_t id, fluid;
    Vec2 place, velocity;
    double density, pressure;  // kg/m^2, N/m
  };
  void look(std::vector<Seen>& out) const;

 private:
  void keep_pressure();
  void recall_pressure();
  void drag();
  void solve();

  const kernels::KernelTable& kernels_;
  WorkerPool& pool_;
  FluidSpace space_;
  std::vector<FluidKind> kinds_;
  std::vector<float> volume_, mass_;  // of a particle, by fluid
  FluidParticles particles_;
  FluidSolver solver_;
  kernels::FluidMotion motion_{};
  double dt_ = 0;
  double viscosity_ = 0;              // m^2/s: the largest
  std::vector<FluidSurvey> surveys_;  // by tile
  std::vector<float> largest_;        // speed, m/s, by tile
  std::uint32_t iterations_ = 0;
  double error_mean_ = 0, error_max_ = 0;
  std::vector<std::uint64_t> old_keys_;  // tiles of the last step, and their pressure
  Column<float> old_pressure_;
};

}  // namespace psim
