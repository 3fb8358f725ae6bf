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
#include <functional>
#include <string>
#include <vector>

#include "fluid/fluid_equations.h"
#include "fluid/fluid_particles.h"
#include "fluid/fluid_solver.h"
#include "fluid/fluid_taps.h"

namespace psim {

class Archive;

/// What a fluid is made of.
struct FluidKind {
  double spacing = 0;    ///< m
  double density = 0;    ///< kg/m^2
  double viscosity = 0;  ///< m^2/s
  double tension = 0;    ///< N/m, of its surface
};

/// One line of what is wrong with a fluid of a world whose first fluid is `first`, or empty.
std::string check_fluid(const FluidKind& kind, const FluidKind& first, const Bounds& bounds, Boundary boundary);

struct FluidCounts {
  std::size_t particles = 0;
  double kinetic = 0;                                    ///< J
  double density_error_mean = 0, density_error_max = 0;  ///< of the cells within the fluid, relative
  std::uint32_t iterations = 0;                          ///< of the last step, for pressure and for density
};

/// How much work a step has to do.
struct FluidWork {
  int parts = 0;      ///< of the step; 0: nothing moves
  double tiles = 0;   ///< in a part, that are not dry
  double passes = 0;  ///< tiles with equations x iterations, in a part
  bool bodies = false;
};

class Fluids {
 public:
  Fluids(MemoryMeter& meter, const kernels::KernelTable& kernels, WorkerPool& pool)
      : kernels_(kernels),
        pool_(pool),
        particles_(meter),
        solver_(meter, kernels, pool),
        bodies_(solver_),
        old_pressure_(meter) {}

  void begin(const FluidSpace& space) { space_ = space; }
  std::uint32_t add_kind(const FluidKind& kind);
  void add(std::uint32_t fluid, Vec2 place, Vec2 velocity);
  /// Moves all fluids by dt seconds. `gravity`: m/s^2. `finder` tells of the bodies around; null: there are none. What
  /// has lain still for long enough is left as it is, if it may rest. It moves in so many parts at most; 0: in as many as
  /// it takes.
  void step(double dt, Vec2 gravity, const SolidFinder* finder, bool may_rest = false, int most_parts = 0);
  /// The work of a step of dt seconds, as far as it is known.
  FluidWork work(double dt, Vec2 gravity) const;
  /// Whether the last step left all as it was.
  bool at_rest() const { return at_rest_; }
  /// What the step did to bodies, by id.
  const std::vector<FluidForce>& forces() const { return bodies_.forces(); }
  /// A body fell asleep after the step.
  void lay_down(std::uint32_t body) { bodies_.lay_down(body); }

  /// Makes room for n particles more, whose add() then needs no memory.
  void make_room(std::size_t n) { particles_.make_room(n); }
  /// As after the constructor.
  void clear();

  const std::vector<FluidKind>& kinds() const { return kinds_; }
  const FluidSpace& space() const { return space_; }
  /// One more than the largest id that a particle had.
  std::uint32_t ids() const { return particles_.next_id(); }
  /// Removes the particles that are not within the bounds.
  void keep_within(const Bounds& bounds) {
    if (particles_.remove(bounds, false, solver_.grid(), space_) != 0) stir();
  }
  /// Lays the grid of an open world, if it had no particle yet, with its corner half a spacing from the first one, as
  /// where a region is full. So it does not matter where a scene lies.
  void lay_corner(const Bounds& bounds, Vec2 first);
  /// Where fluids come from and where they go.
  FluidTaps& taps() { return taps_; }
  const FluidTaps& taps() const { return taps_; }
  /// Removes the particles that are in drains. After step().
  void drain();
  /// Emitters let out what flows in dt seconds. False if there was no memory for some of it. After step() and drain().
  bool emit(double dt, Vec2 gravity, const Bounds& bounds);
  using SeeParticle = std::function<void(const kernels::FluidParticle&, Vec2)>;
  /// Shows the particles within a box, and where they are, m, in an order that is always the same.
  void look_in(const Bounds& box, const SeeParticle& see) const;
  /// What is within a box, and where `holds` says so, of a fluid or of all.
  FluidAmount amount_in(const Bounds& box, FluidId fluid, const std::function<bool(Vec2)>& holds) const;
  std::size_t size() const { return particles_.size(); }
  /// Whether a step has something to do.
  bool active() const { return size() != 0 || taps_.any() || !forces().empty(); }
  std::size_t bytes() const { return particles_.bytes() + solver_.bytes() + old_pressure_.bytes() + bodies_.bytes(); }
  FluidCounts counts() const;
  /// `before` and the particles, by id.
  std::uint64_t hash(std::uint64_t before) const;
  /// For saved states (state/describe_fluids.cpp).
  void describe(Archive& a, const Bounds& bounds, Boundary boundary);
  /// All particles, by id (query/fluid_readout.cpp).
  void look(std::vector<FluidParticleState>& out) const;

 private:
  /// N/m by a unit of FluidSolver::kPressure.
  double pressure_unit() const;
  void let_out(FluidEmitter& emitter, const FluidOutflow& flow, std::size_t count, Vec2 gravity, const Bounds& bounds);
  void describe_kinds(Archive& a, const Bounds& bounds, Boundary boundary);
  bool stays_at_rest(Vec2 gravity, const SolidFinder* finder);
  void note_calm(double dt, Vec2 gravity);
  double half_a_wave(double gravity) const;
  void lay_down();
  void stir() {
    calm_ = 0;
    rests_ = false;
  }
  int parts_of(double dt, Vec2 gravity) const;
  void step_part(Vec2 gravity, double bodies_moved);
  void keep_pressure();
  void recall_pressure(std::size_t tile);
  void find_wet();
  void meet_bodies();
  void drag();
  bool draw_together();
  double steady_tension() const;
  void solve();
  void move_with_grid();

  const kernels::KernelTable& kernels_;
  WorkerPool& pool_;
  FluidSpace space_;
  std::vector<FluidKind> kinds_;
  std::vector<float> volume_, mass_;  // of a particle, by fluid
  std::vector<float> tensions_;  // of a particle, by fluid: its volume times its share of the largest surface tension
  double tension_ = 0;           // N/m: the largest
  double least_density_ = 0;     // kg/m^2, of fluids
  FluidParticles particles_;
  FluidSolver solver_;
  FluidBodies bodies_;
  FluidTaps taps_;
  kernels::FluidMotion motion_{};
  double dt_ = 0;      // s, of a part of the step
  float fastest_ = 0;  // m/s: of full cells in the last step, and of particles that came since
  // For how long all has been calm, s; with which gravity, and among what (FluidBodies::surroundings).
  double calm_ = 0;
  Vec2 calm_gravity_;
  std::uint64_t calm_among_ = 0;
  bool rests_ = false;             // calm for long enough
  bool at_rest_ = false;           // and the last step left all as it was
  double viscosity_ = 0;           // m^2/s: the largest
  bool densities_ = false;         // fluids have different ones
  std::vector<std::uint8_t> wet_;  // by tile: whether cells of it may have equations
  // Tiles that have equations, and those that are not dry.
  std::vector<std::uint32_t> with_equations_, near_;
  std::vector<FluidSurvey> surveys_;          // by tile
  std::vector<float> largest_;                // speed, m/s, by tile
  std::vector<std::vector<FluidHits>> hits_;  // of particles at bodies, by tile
  std::uint32_t iterations_ = 0;
  FluidWork last_;  // of the last step
  double error_mean_ = 0, error_max_ = 0;
  std::vector<std::uint64_t> old_keys_;  // tiles of the last step, and their pressure
  Column<float> old_pressure_;
};

}  // namespace psim
