// World::debug_draw: the observers tell where bodies and contacts are, the joints where their anchors are.
#include <cmath>
#include <utility>
#include <vector>

#include "base/room.h"
#include "query/debug_draw.h"
#include "world/world_impl.h"

namespace psim {
namespace {

bool reaches(const std::optional<Bounds>& region, Vec2 at) {
  return !region || (at.x >= region->xmin && at.x <= region->xmax && at.y >= region->ymin && at.y <= region->ymax);
}

void draw_bounds(const WorldDesc& desc, DebugDraw& to) {
  if (desc.boundary == Boundary::open) return;
  const Bounds& b = desc.bounds;
  const Vec2 corners[] = {{b.xmin, b.ymin}, {b.xmax, b.ymin}, {b.xmax, b.ymax}, {b.xmin, b.ymax}};
  for (std::size_t k = 0; k < 4; ++k) to.line(corners[k], corners[(k + 1) % 4], DrawKind::bounds);
}

void draw_particles(const World& world, const Fluids& fluids, const std::optional<Bounds>& region, DebugDraw& to) {
  std::vector<FluidParticleState> particles;
  world.fluid_particles(particles);
  for (const FluidParticleState& p : particles) {
    const double radius = fluids.kinds()[p.fluid].spacing / 2;
    if (region &&
        !reaches(Bounds{region->xmin - radius, region->ymin - radius, region->xmax + radius, region->ymax + radius},
                 p.position)) {
      continue;
    }
    to.circle(p.position, radius, 0, DrawKind::particle, kNoBody);
  }
}

// A rod or spring is a line; of others the lines lead from the places of the bodies to the anchors.
void draw_joint(const World& world, JointId id, const DebugDrawOptions& options, DebugDraw& to) {
  const std::optional<JointState> joint = world.joint(id);
  if (!joint || joint->type == JointType::filter) return;
  if (options.joints) {
    const auto arm = [&](BodyId body, Vec2 anchor) {
      const auto state = world.body(body);
      if (state && (state->x != anchor.x || state->y != anchor.y))
        to.line({state->x, state->y}, anchor, DrawKind::joint);
    };
    arm(joint->a, joint->anchor_a);
    if (joint->type != JointType::gear && joint->type != JointType::pulley) {
      to.line(joint->anchor_a, joint->anchor_b, DrawKind::joint);
    }
    if (joint->type == JointType::pulley) {
      const std::optional<JointDesc> desc = world.joint_desc(id);
      to.line(desc->ground_a, joint->anchor_a, DrawKind::joint);
      to.line(desc->ground_b, joint->anchor_b, DrawKind::joint);
    }
    arm(joint->b, joint->anchor_b);
  }
  if (options.forces && (joint->force.x != 0 || joint->force.y != 0)) {
    to.line(joint->anchor_b, joint->anchor_b + options.force_scale * joint->force, DrawKind::force);
  }
}

void draw_contact(const Contact& c, const DebugDrawOptions& options, double dt, DebugDraw& to) {
  if (!reaches(options.region, c.point)) return;
  if (options.contacts) {
    to.point(c.point, DrawKind::contact);
    to.line(c.point, c.point + options.normal_length * c.normal, DrawKind::contact);
  }
  if (!options.forces || !(c.impulse > 0)) return;
  const Vec2 side{-c.normal.y, c.normal.x};
  const Vec2 force = (1 / dt) * (c.impulse * c.normal + c.friction * side);
  to.line(c.point, c.point + options.force_scale * force, DrawKind::force);
}

}  // namespace

bool World::debug_draw(DebugDraw& to, const DebugDrawOptions& options) try {
  const FloatSettings settings;
  Owners& w = *impl_;
  const std::optional<Bounds>& r = options.region;
  const auto ordered = [](double low, double high) { return std::isfinite(low) && std::isfinite(high) && low <= high; };
  if (r && !(ordered(r->xmin, r->xmax) && ordered(r->ymin, r->ymax))) return false;
  if (!std::isfinite(options.force_scale) || !std::isfinite(options.normal_length)) return false;
  if (options.bounds) draw_bounds(w.desc, to);
  const bool told = std::exchange(ran_out_of_memory(), false);
  if (options.particles && !w.fluids.kinds().empty()) draw_particles(*this, w.fluids, r, to);
  if (options.bodies) draw_bodies(w.observers.queries, w.observed(), r, to);
  if (options.joints || options.forces) {
    for (std::uint32_t k = 0; k < w.joints.indices(); ++k) draw_joint(*this, w.joints.id_of(k), options, to);
  }
  if (options.contacts || options.forces) {
    for (const Contact& c : contacts()) draw_contact(c, options, w.desc.dt, to);
  }
  const bool all = !ran_out_of_memory();
  ran_out_of_memory() = told || !all;
  return all;
} catch (const std::bad_alloc&) {
  return nothing_found<bool>();
}

}  // namespace psim
