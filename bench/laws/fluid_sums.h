// What fluids and bodies have together: masses, places, energy, momentum.
#pragma once

#include <vector>

#include "change.h"
#include "psim/world.h"

namespace psim::laws {

struct FluidSums {
  double mass = 0;                    ///< kg, of fluids and dynamic bodies
  Vec2 centre;                        ///< m, of their mass
  Vec2 mean, spread;                  ///< m: mean place of the fluids' mass, and its standard deviation along x and y
  double kinetic = 0, potential = 0;  ///< J, rotation of bodies included; uniform gravity from the origin
  Vec2 momentum;                      ///< kg m/s
  double angular = 0;                 ///< kg m^2/s, about the origin
  double height = 0;  ///< m: of the centre over the lowest middle of a body or particle, against gravity
  double moving = 0;  ///< kg m/s: mass times speed, without regard to its direction

  double energy() const { return kinetic + potential; }
};

/// Sums of `world`, which runs `run`, `time` seconds after the start, as those of `scene`, which `change` changed to `run`.
FluidSums sums_of(const World& world, const Scene& run, const Scene& scene, const Change& change, double time);

/// Sums at the start and after each of `frames` frames.
std::vector<FluidSums> sums_course(const Scene& run, const Scene& scene, const Change& change, int frames);

/// Metres: how deep a point lies within a shape of a body there; 0 or less outside. Lines have no inside.
double depth_in(const Shape& shape, const BodyState& body, Vec2 point);

}  // namespace psim::laws
