#include "step/plan.h"

#include "bodies/body_properties.h"
#include "lists/heavy_loads.h"
#include "solver/forces.h"
#include "solver/media.h"

namespace psim {

void take_traits(const WorldDesc& d, Traits& traits) {
  traits.walls = d.boundary == Boundary::walls;
  traits.wall_bounce = coefficient(d.wall.restitution) > 0;
  traits.wall_rough = coefficient(d.wall.friction) > 0;
  traits.wall_special = coefficient(d.wall.tangent_speed) != 0 || coefficient(d.wall.rolling_resistance) != 0;
  traits.one_rubs = d.mixing.friction == Mixing::max || d.mixing.friction == Mixing::mean;
  traits.gravity = d.gravity.x != 0 || d.gravity.y != 0;
  traits.fields = needs_forces(d.fields);
  traits.media = any_medium(d.fields);
  traits.integrator = d.integrator;
  traits.sleeping = d.sleeping;
  traits.damping = d.linear_damping > 0 || linear_drag(d.fields) > 0;
}

Plan make_plan(const Traits& t) {
  Plan p;
  p.fields = t.fields;
  p.scales = t.kinematic != 0 || t.odd_gravity != 0 || t.pushed || t.media;
  p.forces = t.fields || p.scales;
  if (t.fields) p.integrator = t.integrator;
  const bool asking = t.moving != 0 && t.asking != 0;  // the host may want either of a contact
  p.restitution =
      asking || t.moving_bounce != 0 || (t.moving != 0 && (t.fixed_bounce != 0 || (t.walls && t.wall_bounce)));
  const bool ground_rough = t.fixed_rough != 0 || (t.walls && t.wall_rough);
  const auto rub = [&](std::uint64_t rough, std::uint64_t all) {
    if (t.one_rubs) return all != 0 && (rough != 0 || t.moving_rough != 0 || ground_rough);
    return rough >= 2 || (rough == 1 && ground_rough);
  };
  p.friction = asking || rub(t.moving_rough, t.moving);
  p.masses = t.same_mass != t.discs || t.kinematic_discs != 0;
  p.uneven = p.masses || t.cornered != 0;
  p.loads = p.uneven && t.mass_ratio >= static_cast<double>(HeavyLoads::kLeastRatio) && (t.gravity || t.fields);
  p.radii = t.same_radius != t.moving;
  p.materials = t.same_properties != t.discs;
  p.surfaces = t.moving != 0 && (t.special != 0 || (t.walls && t.wall_special));
  p.manifolds = t.cornered != 0 || p.surfaces;
  p.joints = t.joints != 0;
  p.turns = p.manifolds || p.joints;
  p.filters = t.filtered != 0 || t.sensors != 0 || t.exclusions;
  p.bullets = t.bullets != 0 && t.moving > 1;
  p.continuous = p.manifolds || p.bullets || (t.moving != 0 && t.fixed != 0) || t.kinematic != 0;
  p.rotation = p.friction || t.turning || p.turns;
  p.sleep = t.sleeping && t.moving != 0;
  p.events = t.events;
  p.restraints = t.restrained != 0;
  p.publish = t.snapshots;
  p.model.model =
      rub(t.rough_discs, t.discs) ? kernels::Model::rough : (p.masses ? kernels::Model::massed : kernels::Model::plain);
  p.model.bounce = p.restitution;
  return p;
}

std::vector<PlanEntry> explain(const Plan& p, const Traits& t) {
  std::vector<PlanEntry> out;
  const auto add = [&](const char* stage, bool needed, const char* yes, const char* no) {
    out.push_back({stage, needed, needed ? yes : no, 0});
  };
  const bool moves = t.moving != 0;
  const std::string higher = std::string(integrator_name(p.integrator)) + " moves bodies in the fields, " +
                             (p.integrator == Integrator::euler ? "one evaluation" : "four evaluations") + " a substep";
  add("forces", p.forces, "wells, quadratic drag, wind, water, gravity scales, applied forces or kinematic bodies",
      "gravity is uniform: part of the kick");
  add("forces.integrator", p.integrator != Integrator::verlet, higher.c_str(),
      t.fields ? "verlet: the kick and the drift are leapfrog already"
               : "gravity is uniform: every integrator is the closed form");
  add("restraints", p.restraints, "some bodies have damping or locks of their own", "no body has any of its own");
  add("damping", t.damping, "linear damping or drag, integrated exactly", "no damping and no drag");
  add("broad_phase", moves, "bodies move", "no body moves");
  add("broad_phase.walls", t.walls && moves, "the world has walls", "the world has no walls");
  add("broad_phase.fixed_shapes", t.fixed != 0 && moves, "discs, segments or chains stand fixed",
      "nothing stands fixed");
  add("broad_phase.mixed_radii", p.radii, "radii differ", "all moving discs have one radius");
  add("narrow_phase", moves, "bodies move", "no body moves");
  add("colouring", moves, "bodies move", "no body moves");
  add("solver", moves, "bodies may touch", "no body moves");
  add("solver.restitution", p.restitution, "a material bounces, or the host is asked: time-of-impact sweeps",
      "no body and no wall has restitution");
  add("solver.masses", p.masses, "masses of discs differ", "all moving discs have one mass");
  add("solver.heavy_loads", p.loads, "some bodies may carry others eight times as heavy",
      "no body carries one eight times as heavy");
  add("solver.friction", p.friction, "two surfaces that can meet have friction, or the host is asked",
      "no two surfaces that can meet have friction");
  add("manifolds", p.manifolds, "bodies other than discs", "all moving bodies are discs");
  add("surfaces", p.surfaces, "some surfaces run, resist rolling, are solid from one side or ask the host",
      "no surface runs, resists rolling, is solid from one side or asks the host");
  add("joints", p.joints, "bodies are joined", "no body is joined to another");
  add("filters", p.filters, "some bodies do not collide with others, or are sensors",
      "everybody collides with everybody");
  add("continuous", p.continuous, "fast bodies may meet shapes, fixed or kinematic bodies, or are bullets",
      "discs alone, nothing stands fixed, and nobody is a bullet");
  add("rotation", p.rotation, "friction, a shape, a joint or a given spin turns bodies", "nothing turns a body");
  add("integrate", moves, "bodies move", "no body moves");
  add("fluid", t.fluids, "there are particles of fluids, or taps", "the world has no fluid");
  add("sleep", p.sleep, "bodies that come to rest are left out",
      t.sleeping ? "no body moves" : "the world's bodies never sleep");
  add("events", p.events, "the host asks for contacts, hits or sensors", "nobody asks for events");
  add("publish", p.publish, "a renderer reads snapshots", "no renderer is attached");
  return out;
}

}  // namespace psim
