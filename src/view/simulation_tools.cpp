// What hands do to the world, all of it through the public API.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "shape_size.h"
#include "simulation.h"

namespace psim::view {
namespace {

const QueryFilter kMovable{.kinematic = false, .fixed = false};

PolygonShape hexagon(double radius) {
  PolygonShape shape;
  for (int k = 0; k < 6; ++k) {
    const double at = k * std::numbers::pi / 3;
    shape.vertices.push_back({radius * std::cos(at), radius * std::sin(at)});
  }
  return shape;
}

Shape spawn_shape(SpawnShape shape, double radius) {
  switch (shape) {
    case SpawnShape::box:
      return BoxShape{1.6 * radius, 1.6 * radius};
    case SpawnShape::polygon:
      return hexagon(radius);
    case SpawnShape::capsule:
      return CapsuleShape{{-0.5 * radius, 0}, {0.5 * radius, 0}, 0.5 * radius};
    case SpawnShape::disc:
      break;
  }
  return DiscShape{radius};
}

// A place in 0..1 by number: evenly spread, and the same in every run.
double spread(std::uint64_t number) {
  const double turns = static_cast<double>(number) * std::numbers::phi;
  return turns - std::floor(turns);
}

}  // namespace

double Simulation::mass_of(const BodyState& state) const {
  return catalogue_->mass(state.id.index, state.radius);
}

void Simulation::grab(Vec2 at, double reach) {
  let_go();
  const auto hit = world_->closest(at, reach, kMovable);
  if (!hit) return;
  const auto body = world_->body(hit->body);
  if (!body || body->type != BodyType::dynamic_body) return;
  const double c = std::cos(body->angle), s = std::sin(body->angle);
  const double dx = hit->point.x - body->x, dy = hit->point.y - body->y;
  grab_ = Grab{hit->body, {c * dx + s * dy, c * dy - s * dx}, at};
}

void Simulation::drag(Vec2 to) {
  if (grab_) grab_->target = to;
}

void Simulation::let_go() { grab_.reset(); }

// A soft spring: the grabbed point is steered to be at the target in kFrames frames. Its arm makes
// it lighter than the body, so a share of the impulse suffices and never overshoots.
void Simulation::pull() {
  constexpr double kFrames = 6, kShare = 0.3;
  const auto body = world_->body(grab_->body);
  if (!body) return let_go();
  world_->wake(grab_->body);
  const Vec2 held = to_world(grab_->arm, {body->x, body->y}, body->angle);
  const double rx = held.x - body->x, ry = held.y - body->y;
  const double vx = body->vx - body->omega * ry, vy = body->vy + body->omega * rx;
  const double rate = 1 / (kFrames * dt());
  const Vec2& g = settings_.gravity;
  const double m = mass_of(*body);
  world_->apply_impulse_at(grab_->body,
                           {m * (kShare * ((grab_->target.x - held.x) * rate - vx) - g.x * dt()),
                            m * (kShare * ((grab_->target.y - held.y) * rate - vy) - g.y * dt())},
                           held);
}

void Simulation::add(BodyDesc desc) {
  std::string error;
  const BodyId id = world_->add_body(desc, error);
  if (id == kNoBody) {
    message_ = error;
    return;
  }
  catalogue_->set(id.index, desc, desc.type);
  told_catalogue_.reset();
  forget_joints_of(id.index);  // of a body that left an open world
  added_.push_back({id, std::move(desc)});
  changed_ = true;
}

// Its id may be another body's soon.
void Simulation::forget_joints_of(std::uint32_t id) {
  const auto names_it = [id](const JointLook& joint) { return joint.a == id || joint.b == id; };
  if (std::ranges::none_of(*joints_, names_it)) return;
  std::vector<JointLook> left = *joints_;
  std::erase_if(left, names_it);
  joints_ = std::make_shared<const std::vector<JointLook>>(std::move(left));
}

void Simulation::spawn(Vec2 at, SpawnShape shape, double size) {
  const double jitter = 2 * size * (spread(++spawned_) - 0.5);
  const Vec2 place{at.x + jitter, at.y + size * (spread(spawned_ + 7) - 0.5)};
  if (world_->closest(place, 1.05 * size)) return;  // it would overlap
  BodyDesc desc;
  desc.shape = spawn_shape(shape, size);
  desc.position = place;
  if (!scene_->bodies.empty()) desc.material = scene_->bodies.back().material;
  if (!scene_->groups.empty()) desc.material = scene_->groups.back().body.material;
  if (settings_.restitution) desc.material.restitution = *settings_.restitution;
  if (settings_.friction) desc.material.friction = *settings_.friction;
  add(std::move(desc));
}

void Simulation::explode(Vec2 at, double reach, double speed) {
  for (const BodyId id : world_->overlap(DiscShape{reach}, at, 0, kMovable)) {
    const auto body = world_->body(id);
    if (!body) continue;
    const double dx = body->x - at.x, dy = body->y - at.y, d = std::hypot(dx, dy);
    if (!(d > 0)) continue;
    const double push = mass_of(*body) * speed * std::max(1 - d / (2 * reach), 0.0) / d;
    world_->apply_impulse(id, {push * dx, push * dy});
  }
  changed_ = true;
}

void Simulation::add_well(Vec2 at, double strength, double range) {
  wells_.push_back({.position = at,
                    .strength = strength,
                    .softening = 0.05 * range,
                    .exponent = 1,
                    .range = range});
  set_settings(settings_);
}

void Simulation::add_wall(Vec2 from, Vec2 to) {
  if (std::hypot(to.x - from.x, to.y - from.y) < 1e-6) return;
  BodyDesc desc;
  desc.type = BodyType::static_body;
  desc.position = {(from.x + to.x) / 2, (from.y + to.y) / 2};
  const double x = (to.x - from.x) / 2, y = (to.y - from.y) / 2;
  desc.shape = SegmentShape{{-x, -y}, {x, y}};
  desc.material = scene_->world.wall;
  add(std::move(desc));
}

void Simulation::erase(Vec2 at, double reach) {
  const auto hit = world_->closest(at, reach);
  if (!hit) return;
  world_->remove_body(hit->body);
  std::erase_if(added_, [&](const Added& one) { return one.id == hit->body; });
  forget_joints_of(hit->body.index);
  changed_ = true;
}

}  // namespace psim::view
