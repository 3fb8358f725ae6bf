// Random scenes with fluids: one or two of them in a pen or above terrain, and bodies that float or sink.
#pragma once

#include "draw.h"
#include "psim/scene.h"

namespace psim::laws {

/// What a law asks of the scenes that it is tried on.
struct FluidScope {
  bool walls = true;                       ///< the walls of the world may be the pen
  bool open = true;                        ///< a pen may have no lid, and there are scenes on terrain without a pen
  bool driven = true;                      ///< kinematic bodies may move
  bool tension = true;                     ///< surfaces may have a tension
  bool beside = false;                     ///< fluids may begin beside a line, where it counts as wider than it is
  double fluid_speed = 5, body_speed = 3;  ///< m/s, at most
};

/// The name of the body of a scene which parts its pen: fluids start to the left of it.
inline constexpr const char* kPartition = "partition";
/// Metres: a pen goes from -kPen to kPen both ways.
inline constexpr double kPen = 6;

/// Fluids and bodies in a pen or above terrain, 200 to 3,000 particles.
Scene fluid_scene(Draw& draw, const FluidScope& scope);
/// Fluids and bodies that meet in open space without gravity.
Scene fluid_adrift(Draw& draw);
/// A closed pen, sometimes parted, whose fluids and bodies may be fast.
Scene fast_fluid_pen(Draw& draw);

/// The same with all particles one by one, as a world places them: so changes of a scene change each of them.
Scene with_particles(const Scene& scene);
/// m^2: of all fluids of a scene.
double fluid_area(const Scene& scene);

}  // namespace psim::laws
