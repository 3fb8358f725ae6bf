// What a scene needs, decided from its traits whenever they change: which stages run and which
// variants of the contact kernels. What is not in the plan owns no memory and costs no branch.
#pragma once

#include <cstdint>
#include <vector>

#include "contact_store.h"
#include "psim/integrator.h"
#include "psim/report.h"

namespace psim {

/// Counted as bodies come and go.
struct Traits {
  std::uint64_t moving = 0;           ///< dynamic and kinematic bodies
  std::uint64_t discs = 0;            ///< of those, plain discs: contacts of their own kind
  std::uint64_t held_discs = 0;       ///< kinematic ones
  std::uint64_t rough_discs = 0;      ///< with friction
  std::uint64_t same_mass = 0;        ///< discs with the first one's mass
  std::uint64_t same_radius = 0;
  std::uint64_t same_surface = 0;     ///< discs with the first one's mass, friction and restitution
  std::uint64_t moving_bounce = 0;    ///< with restitution
  std::uint64_t moving_rough = 0;     ///< with friction
  std::uint64_t kinematic = 0;
  std::uint64_t odd_gravity = 0;      ///< gravity scale other than 1
  std::uint64_t fixed = 0;
  std::uint64_t fixed_bounce = 0;
  std::uint64_t fixed_rough = 0;
  std::uint64_t cornered = 0;         ///< moving bodies other than discs
  std::uint64_t filtered = 0;         ///< bodies that do not collide with all others
  std::uint64_t sensors = 0;
  std::uint64_t bullets = 0;
  std::uint64_t joints = 0;
  bool exclusions = false;            ///< some joined bodies do not collide
  bool turning = false;               ///< some body was given an angle or a spin
  bool walls = false, wall_bounce = false, wall_rough = false;
  double mass_ratio = 1;              ///< heaviest to lightest dynamic body
  bool gravity = false;
  bool fields = false;                ///< wells or quadratic drag
  Integrator integrator = Integrator::verlet;
  bool damping = false;
  bool snapshots = false;
  bool events = false;                ///< the host asked for some
  bool sleeping = true;               ///< bodies may
  friend bool operator==(const Traits&, const Traits&) = default;
};

struct Plan {
  bool forces = false;       ///< accelerations differ from body to body
  bool fields = false;       ///< and with place or speed: every body takes substeps
  bool scales = false;       ///< and gravity does not act on all alike
  Integrator integrator = Integrator::verlet;  ///< verlet where there are no fields
  bool friction = false;
  bool restitution = false;
  bool masses = false;       ///< of discs, unequal
  bool uneven = false;       ///< of any two bodies that meet
  bool loads = false;        ///< so unequal that some may carry much heavier ones
  bool radii = false;        ///< unequal
  bool surfaces = false;     ///< of discs: mass, friction or restitution unequal
  bool rotation = false;
  bool shapes = false;       ///< moving bodies other than discs: manifolds
  bool filters = false;      ///< not everybody collides with everybody
  bool joints = false;
  bool turns = false;        ///< what points of a body do within a frame: shapes or joints
  bool continuous = false;   ///< fast bodies are looked after
  bool bullets = false;      ///< also against other moving bodies
  bool sleep = false;
  bool events = false;
  bool publish = false;
  ContactModel model;

  friend bool operator==(const Plan&, const Plan&) = default;
};

Plan make_plan(const Traits& traits);

/// The plan as a table for people, with the reason of every entry; bytes are left 0.
std::vector<PlanEntry> explain(const Plan& plan, const Traits& traits);

}  // namespace psim
