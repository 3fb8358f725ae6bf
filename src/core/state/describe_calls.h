// How recordings write what calls of the host are given.
#pragma once

#include <tuple>

#include "psim/fluid.h"
#include "psim/report.h"
#include "state/describe.h"

namespace psim {

inline auto fields(StepDetail& d) {
  return std::tie(d.substeps, d.solves, d.frames, d.horizon, d.pieces, d.wakes, d.sweeps, d.fluid_parts);
}
inline auto fields(DiscShape& s) { return std::tie(s.radius); }
inline auto fields(SegmentShape& s) { return std::tie(s.p1, s.p2); }
inline auto fields(ChainShape& s) { return std::tie(s.vertices, s.loop, s.materials); }
inline auto fields(BoxShape& s) { return std::tie(s.width, s.height, s.radius); }
inline auto fields(PolygonShape& s) { return std::tie(s.vertices, s.radius); }
inline auto fields(CapsuleShape& s) { return std::tie(s.p1, s.p2, s.radius); }
inline auto fields(ShapePart& p) {
  return std::tie(p.shape, p.position, p.angle, p.density, p.restitution, p.friction, p.filter, p.sensor,
                  p.tangent_speed, p.rolling_resistance, p.one_way, p.pre_solve, p.user_data);
}
inline auto fields(CompoundShape& s) { return std::tie(s.parts); }
inline auto fields(BodyDesc& d) {
  return std::tie(d.type, d.shape, d.position, d.angle, d.velocity, d.angular_velocity, d.material, d.mass,
                  d.gravity_scale, d.fixed_rotation, d.bullet, d.sensor, d.filter, d.linear_damping, d.angular_damping,
                  d.locks, d.one_way, d.enabled, d.user_data, d.pre_solve, d.can_sleep);
}
inline auto fields(FluidDesc& d) { return std::tie(d.spacing, d.density, d.viscosity, d.surface_tension); }
inline auto fields(EmitterDesc& d) { return std::tie(d.fluid, d.from, d.to, d.speed, d.start, d.end, d.limit); }
inline auto fields(Explosion& e) { return std::tie(e.position, e.radius, e.falloff, e.impulse_per_length, e.mask); }
inline auto fields(BodyTraits& t) {
  return std::tie(t.filter, t.restitution, t.friction, t.tangent_speed, t.rolling_resistance, t.one_way, t.sensor,
                  t.bullet, t.mass, t.inertia, t.gravity_scale, t.linear_damping, t.angular_damping, t.locks,
                  t.pre_solve, t.can_sleep);
}
inline auto fields(PartTraits& t) {
  return std::tie(t.filter, t.restitution, t.friction, t.tangent_speed, t.rolling_resistance, t.one_way, t.sensor,
                  t.pre_solve, t.user_data);
}

}  // namespace psim
