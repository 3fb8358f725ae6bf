// Scene -> World: `bodies` in order, then `groups`, so that ids are as the scene says; then joints and
// fluids.
// O(n).
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/machine.h"
#include "base/rotor.h"
#include "place/fluid_overlaps.h"
#include "place/fluid_places.h"
#include "place/links.h"
#include "place/placement.h"
#include "place/shape_size.h"
#include "psim/scene.h"

namespace psim {
namespace {

bool add_body(World& world, const Scene& scene, std::size_t k, std::string& error) {
  std::string what;
  if (world.add_body(scene.bodies[k], what) != kNoBody) return true;
  error = "bodies[" + std::to_string(k) + "]";
  if (k < scene.body_names.size() && !scene.body_names[k].empty()) {
    error += " \"" + scene.body_names[k] + "\"";
  }
  error += ": " + what;
  return false;
}

// Bodies first..last-1 of a group of discs, which are all of this type.
bool add_discs(World& world, const BodyDesc& body, const PlacedGroup& placed, std::size_t first, std::size_t last,
               BodyType type, std::string& error) {
  const std::size_t n = last - first;
  const auto part = [&](const std::vector<double>& column) { return std::span(column).subspan(first, n); };
  std::vector<double> angle, angular_velocity;
  if (body.angle != 0) angle.assign(n, body.angle);
  if (body.angular_velocity != 0) angular_velocity.assign(n, body.angular_velocity);
  DiscBatch batch;
  batch.x = part(placed.x);
  batch.y = part(placed.y);
  batch.radius = part(placed.radius);
  batch.angle = angle;
  batch.vx = part(placed.vx);
  batch.vy = part(placed.vy);
  batch.angular_velocity = angular_velocity;
  batch.type = type;
  batch.material = body.material;
  batch.mass = body.mass;
  batch.gravity_scale = body.gravity_scale;
  batch.fixed_rotation = body.fixed_rotation;
  batch.bullet = body.bullet;
  batch.filter = body.filter;
  std::uint32_t unused = 0;
  return world.add_discs(batch, unused, error) == n;
}

bool add_one_by_one(World& world, const GroupDesc& group, const PlacedGroup& placed, std::string& error) {
  BodyDesc body = group.body;
  for (std::size_t k = 0; k < placed.x.size(); ++k) {
    body.type = is_pinned(group, k) ? BodyType::static_body : group.body.type;
    body.position = {placed.x[k], placed.y[k]};
    body.velocity = {placed.vx[k], placed.vy[k]};
    if (is_disc(group.body.shape)) body.shape = DiscShape{placed.radius[k]};
    if (world.add_body(body, error) == kNoBody) {
      error = "body " + std::to_string(k) + ": " + error;
      return false;
    }
  }
  return true;
}

bool add_placed(World& world, const GroupDesc& group, const PlacedGroup& placed, std::string& error) {
  const BodyDesc &body = group.body, plain;
  const bool restrained = body.linear_damping != 0 || body.angular_damping != 0 || body.locks != plain.locks;
  if (!is_disc(body.shape) || body.sensor || restrained || !body.enabled || body.one_way != plain.one_way) {
    return add_one_by_one(world, group, placed, error);
  }
  const std::size_t n = placed.x.size();
  for (std::size_t first = 0, last = 0; first < n; first = last) {
    const bool pinned = is_pinned(group, first);
    // A group without pins is a single batch.
    const bool pins = group.links && group.links->pin != Pin::none;
    last = pins ? first + 1 : n;
    while (last < n && is_pinned(group, last) == pinned) ++last;
    const BodyType type = pinned ? BodyType::static_body : group.body.type;
    if (!add_discs(world, group.body, placed, first, last, type, error)) return false;
  }
  return true;
}

bool add_group(World& world, const Scene& scene, std::size_t k, std::string& error) {
  const GroupDesc group = seeded_group(scene, k);
  std::string what;
  const std::optional<PlacedGroup> placed = place_group(group, what);
  if (placed && add_placed(world, group, *placed, what)) return true;
  error = "groups[" + std::to_string(k) + "]: " + what;
  return false;
}

// `made`: the joints so far, of which gears are made.
bool add_joint(World& world, const SceneJoint& joint, const std::string& name, std::vector<JointId>& made,
               std::string& error) {
  const auto body = [&world](std::uint64_t id) {
    return id == kWorldSide ? kWorldBody : world.id_of(static_cast<std::uint32_t>(id));
  };
  JointDesc desc = joint.joint;
  desc.a = body(joint.a);
  desc.b = body(joint.b);
  if (desc.type == JointType::gear) {
    if (std::max(joint.joint_a, joint.joint_b) >= made.size()) {
      error = name + ": a gear needs two joints before it";
      return false;
    }
    desc.joint_a = made[joint.joint_a];
    desc.joint_b = made[joint.joint_b];
  }
  std::string what;
  made.push_back(world.add_joint(desc, what));
  if (made.back() != kNoJoint) return true;
  error = name + ": " + what;
  return false;
}

// A beam is a weld half-way between its bodies.
void meet_halfway(const World& world, SceneJoint& link) {
  const auto body = [&world](std::uint64_t id) { return world.body(world.id_of(static_cast<std::uint32_t>(id))); };
  const std::optional<BodyState> a = body(link.a), b = body(link.b);
  if (!a || !b) return;
  const Vec2 half = {(b->x - a->x) / 2, (b->y - a->y) / 2};
  const auto seen_from = [](const BodyState& of, Vec2 way) {
    const SineCosine r = sine_cosine(-of.angle);
    return Vec2{r.cosine * way.x - r.sine * way.y, r.sine * way.x + r.cosine * way.y};
  };
  link.joint.anchor_a = seen_from(*a, half);
  link.joint.anchor_b = seen_from(*b, {-half.x, -half.y});
}

bool add_joints(World& world, const Scene& scene, std::string& error) {
  std::vector<JointId> made;
  for (std::size_t k = 0; k < scene.joints.size(); ++k) {
    const std::string name = "joints[" + std::to_string(k) + "]";
    if (!add_joint(world, scene.joints[k], name, made, error)) return false;
  }
  const SceneBodies bodies(scene);
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    std::vector<SceneJoint> links;
    append_links(scene.groups[k], bodies.first_of_group(k), links);
    const std::string name = "groups[" + std::to_string(k) + "].links";
    const std::optional<LinkDesc>& desc = scene.groups[k].links;
    if (desc && desc->bending > 0 && !may_bend(scene.groups[k])) {
      error = name + ": bending " + kMayBend;
      return false;
    }
    for (SceneJoint& link : links) {
      if (link.joint.type == JointType::weld) meet_halfway(world, link);
      if (!add_joint(world, link, name, made, error)) return false;
    }
  }
  return true;
}

bool add_fluid(World& world, const Scene& scene, std::size_t k, std::string& error) {
  std::string what;
  PlacedParticles placed;
  const FluidId fluid = world.add_fluid(scene.fluids[k].fluid, what);
  if (fluid != kNoFluid && place_particles(scene.fluids[k], placed, what)) {
    lay_above_bodies(world, scene, k, placed);
    if (world.add_particles(fluid, placed.positions, placed.velocities, what)) return true;
  }
  error = "fluids[" + std::to_string(k) + "]: " + what;
  return false;
}

bool add_taps(World& world, const Scene& scene, std::string& error) {
  std::string what;
  for (std::size_t k = 0; k < scene.emitters.size(); ++k) {
    if (world.add_emitter(scene.emitters[k], what) != kNoEmitter) continue;
    error = "emitters[" + std::to_string(k) + "]: " + what;
    return false;
  }
  for (std::size_t k = 0; k < scene.drains.size(); ++k) {
    if (world.add_drain(scene.drains[k], what) != kNoDrain) continue;
    error = "drains[" + std::to_string(k) + "]: " + what;
    return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<World> build_world(const Scene& scene, const RunOptions& options, std::string& error) {
  const FloatSettings settings;
  std::unique_ptr<World> world = World::create(scene.world, options, error);
  if (!world) return nullptr;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    if (!add_body(*world, scene, k, error)) return nullptr;
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    if (!add_group(*world, scene, k, error)) return nullptr;
  }
  if (!add_joints(*world, scene, error)) return nullptr;
  for (std::size_t k = 0; k < scene.fluids.size(); ++k) {
    if (!add_fluid(*world, scene, k, error)) return nullptr;
  }
  if (!add_taps(*world, scene, error)) return nullptr;
  return world;
}

}  // namespace psim
