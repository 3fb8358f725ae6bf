// What the plan of a world is decided from (step/plan.h). Population counts the bodies by kind, the world fills in the
// rest.
#pragma once

#include <cstdint>

#include "psim/integrator.h"

namespace psim {

struct BodyCounts {
  std::uint64_t moving = 0;           ///< dynamic and kinematic bodies
  std::uint64_t discs = 0;            ///< moving plain discs: their contacts have kernels of their own
  std::uint64_t kinematic_discs = 0;  ///< kinematic plain discs
  std::uint64_t rough_discs = 0;      ///< moving plain discs with friction
  std::uint64_t same_mass = 0;        ///< discs with the mass of the first disc
  std::uint64_t same_radius = 0;      ///< moving bodies with the radius of the first moving body
  std::uint64_t same_properties = 0;  ///< discs with the mass, friction and restitution of the first disc
  std::uint64_t moving_bounce = 0;    ///< moving bodies with restitution
  std::uint64_t moving_rough = 0;     ///< moving bodies with friction
  std::uint64_t kinematic = 0;
  std::uint64_t odd_gravity = 0;  ///< bodies with a gravity scale other than 1
  std::uint64_t fixed = 0;
  std::uint64_t fixed_bounce = 0;
  std::uint64_t fixed_rough = 0;
  std::uint64_t cornered = 0;        ///< moving bodies other than discs
  std::uint64_t filtered = 0;        ///< bodies that do not collide with all others
  std::uint64_t sensors = 0;         ///< bodies with a sensor
  std::uint64_t moving_sensors = 0;  ///< those of them that move
  std::uint64_t bullets = 0;
  std::uint64_t special =
      0;  ///< bodies with a surface that runs, resists rolling or is solid from one side, or that ask
  std::uint64_t asking = 0;      ///< bodies whose new contacts the host is shown
  std::uint64_t restrained = 0;  ///< bodies with damping or locks of their own
  friend bool operator==(const BodyCounts&, const BodyCounts&) = default;
};

struct Traits : BodyCounts {
  std::uint64_t joints = 0;
  bool exclusions = false;  ///< some joined bodies do not collide
  bool turning = false;     ///< some body has an angle or an angular velocity
  bool walls = false, wall_bounce = false, wall_rough = false;
  bool wall_special = false;  ///< the walls run or resist rolling
  bool one_rubs = false;      ///< a contact has friction if one of its materials has: a rule of the world
  double mass_ratio = 1;      ///< heaviest to lightest dynamic body
  bool gravity = false;
  bool fields = false;  ///< wells or quadratic drag
  bool pushed = false;  ///< the host applied a force once
  bool media = false;   ///< wind or water
  Integrator integrator = Integrator::verlet;
  bool damping = false;
  bool snapshots = false;
  bool events = false;   ///< the host asked for some
  bool sleeping = true;  ///< bodies may fall asleep
  bool fluids = false;   ///< there are fluids: looked up for the plan that people read
  friend bool operator==(const Traits&, const Traits&) = default;
};

}  // namespace psim
