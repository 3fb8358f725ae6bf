// What joints and bodies look like (World::debug_draw), and which joints a cut goes through: the observers tell where bodies and contacts are, the joints where their anchors are.
#include <algorithm>
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

using Line = std::pair<Vec2, Vec2>;

// Calls each(from, to) for the lines of a joint. A rod or spring is a line; of others the lines lead from the places of the
// bodies to the anchors.
template <class Each>
void each_line(const World& world, JointId id, const JointState& joint, const Each& each) {
  if (joint.type == JointType::filter) return;
  const auto arm = [&](BodyId body, Vec2 anchor) {
    const auto state = world.body(body);
    if (state && (state->x != anchor.x || state->y != anchor.y)) each(Vec2{state->x, state->y}, anchor);
  };
  arm(joint.a, joint.anchor_a);
  if (joint.type == JointType::pulley) {
    const std::optional<JointDesc> desc = world.joint_desc(id);
    each(desc->ground_a, joint.anchor_a);
    each(desc->ground_b, joint.anchor_b);
  } else if (joint.type != JointType::gear) {
    each(joint.anchor_a, joint.anchor_b);
  }
  arm(joint.b, joint.anchor_b);
}

void draw_joint(const World& world, JointId id, const DebugDrawOptions& options, DebugDraw& to) {
  const std::optional<JointState> joint = world.joint(id);
  if (!joint) return;
  if (options.joints) {
    each_line(world, id, *joint, [&](Vec2 from, Vec2 end) { to.line(from, end, DrawKind::joint); });
  }
  if (options.forces && joint->type != JointType::filter && (joint->force.x != 0 || joint->force.y != 0)) {
    to.line(joint->anchor_b, joint->anchor_b + options.force_scale * joint->force, DrawKind::force);
  }
}

// Which side of a line a point is on: 1 left, -1 right, 0 on it.
int side_of_line(const Line& line, Vec2 point) {
  const double area = cross(line.second - line.first, point - line.first);
  return (area > 0) - (area < 0);
}

// Whether two segments have a point in common.
bool have_common_point(const Line& a, const Line& b) {
  const auto apart = [](double a0, double a1, double b0, double b1) {
    return std::max(a0, a1) < std::min(b0, b1) || std::max(b0, b1) < std::min(a0, a1);
  };
  if (apart(a.first.x, a.second.x, b.first.x, b.second.x) || apart(a.first.y, a.second.y, b.first.y, b.second.y)) {
    return false;
  }
  return side_of_line(a, b.first) * side_of_line(a, b.second) <= 0 &&
         side_of_line(b, a.first) * side_of_line(b, a.second) <= 0;
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

std::vector<JointId> World::joints_across(Vec2 from, Vec2 to) const try {
  const FloatSettings settings;
  std::vector<JointId> found;
  if (!std::isfinite(from.x + from.y) || !std::isfinite(to.x + to.y)) return found;
  for (std::uint32_t k = 0; k < impl_->joints.indices(); ++k) {
    const JointId id = impl_->joints.id_of(k);
    const std::optional<JointState> state = joint(id);
    if (!state) continue;
    bool crossed = false;
    each_line(*this, id, *state, [&](Vec2 a, Vec2 b) { crossed = crossed || have_common_point({a, b}, {from, to}); });
    if (crossed) found.push_back(id);
  }
  return found;
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<JointId>>();
}

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
