// What hands do to the world, all of it through the public API.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "model/simulation.h"
#include "place/shape_size.h"

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

double Simulation::mass_of(const BodyState& state) const { return catalogue_->mass(state.id.index, state.radius); }

// The springs end far from the anchor at right angles and are as long as that is far: together one soft
// pin that is damped whichever way the body moves. A single spring of length 0 would let it circle.
void Simulation::grab(Vec2 at, double reach) {
  constexpr double kFrequency = 25;      // rad/s
  constexpr double kMostPull = 1000;     // m/s^2
  constexpr double kSpringLength = 100;  // times the stretch: nearly parallel wherever the body is
  let_go();
  const auto hit = world_->closest(at, reach, kMovable);
  if (!hit) return;
  const auto body = world_->body(hit->body);
  if (!body || body->type != BodyType::dynamic_body) return;
  BodyDesc desc;
  desc.type = BodyType::kinematic_body;
  desc.shape = DiscShape{body->radius};  // of a size that the world has: lists follow the smallest
  desc.position = inside(hit->point);
  desc.filter = {.category = 0, .mask = 0};
  std::string error;
  const BodyId anchor = world_->add_body(desc, error);
  if (anchor == kNoBody) {
    message_ = error;
    return;
  }
  forget_joints_of(anchor.index);
  catalogue_->hide(anchor.index);
  told_catalogue_.reset();
  const double c = std::cos(body->angle), s = std::sin(body->angle);
  const Vec2 d = way({body->x, body->y}, hit->point);
  grab_ = Grab{hit->body,
               anchor,
               {c * d.x + s * d.y, c * d.y - s * d.x},
               at,
               std::max(kMostPull / (kFrequency * kFrequency), body->radius)};
  changed_ = true;
  const double mass = mass_of(*body), far = kSpringLength * grab_->stretch;
  for (const Vec2 end : {Vec2{far, 0}, Vec2{0, far}}) {
    JointDesc spring;
    spring.type = JointType::spring;
    spring.a = anchor;
    spring.b = hit->body;
    spring.anchor_a = end;
    spring.anchor_b = grab_->arm;
    spring.length = far;
    spring.stiffness = mass * kFrequency * kFrequency;
    spring.damping = 2 * mass * kFrequency;
    spring.collide = true;
    if (world_->add_joint(spring, error) != kNoJoint) continue;
    message_ = error;
    return let_go();
  }
}

void Simulation::drag(Vec2 to) {
  if (grab_) grab_->target = to;
}

void Simulation::let_go() {
  if (!grab_) return;
  world_->remove_body(grab_->anchor);  // and the springs
  grab_.reset();
  changed_ = true;
}

// From one place to another, by the short way over a seam.
Vec2 Simulation::way(Vec2 from, Vec2 to) const {
  Vec2 d{to.x - from.x, to.y - from.y};
  if (world_->desc().boundary != Boundary::periodic) return d;
  const Bounds& b = world_->desc().bounds;
  d.x = std::remainder(d.x, b.xmax - b.xmin);
  d.y = std::remainder(d.y, b.ymax - b.ymin);
  return d;
}

// The nearest place of the world: a body that leaves an open one is taken out.
Vec2 Simulation::inside(Vec2 place) const {
  constexpr double kMargin = 1e-6;
  const Bounds& b = world_->desc().bounds;
  const double x = kMargin * (b.xmax - b.xmin), y = kMargin * (b.ymax - b.ymin);
  return {std::clamp(place.x, b.xmin + x, b.xmax - x), std::clamp(place.y, b.ymin + y, b.ymax - y)};
}

// Before every step: the anchor goes after the pointer, but no further from the body than `stretch`,
// which bounds the pull on one that cannot follow.
void Simulation::lead() {
  constexpr double kRate = 12;  // 1/s
  const auto body = world_->body(grab_->body), anchor = world_->body(grab_->anchor);
  if (!body || !anchor) return let_go();
  world_->wake(grab_->body);
  const Vec2 place{anchor->x, anchor->y};
  const Vec2 held = to_world(grab_->arm, {body->x, body->y}, body->angle);
  const Vec2 rest = way(place, inside(grab_->target));
  const double share = std::min(kRate * dt(), 1.0);
  Vec2 ahead = way(held, {place.x + share * rest.x, place.y + share * rest.y});
  const double far = std::hypot(ahead.x, ahead.y);
  if (far > grab_->stretch) ahead = {ahead.x * grab_->stretch / far, ahead.y * grab_->stretch / far};
  const Vec2 step = way(place, inside({held.x + ahead.x, held.y + ahead.y}));
  world_->set_velocity(grab_->anchor, {step.x / dt(), step.y / dt()}, 0);
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

void Simulation::forget_broken_joints(std::span<const JointBreak> breaks) {
  std::vector<JointLook> left = *joints_;
  const auto broke = [breaks](const JointLook& joint) {
    const auto at =
        std::ranges::lower_bound(breaks, joint.number, {}, [](const JointBreak& b) { return b.joint.index; });
    return at != breaks.end() && at->joint.index == joint.number;
  };
  std::erase_if(left, broke);
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

void Simulation::explode(Vec2 at, double reach, double strength) {
  world_->explode({.position = at, .radius = reach / 2, .falloff = reach / 2, .impulse_per_length = strength});
  changed_ = true;
}

void Simulation::add_well(Vec2 at, double strength, double range) {
  std::vector<Field> fields = world_->desc().fields;
  fields.emplace_back(WellField{at, strength, 0.05 * range, 1, range});
  if (world_->set_fields(fields, message_)) note_wells();
}

void Simulation::note_wells() {
  std::vector<Vec2> places;
  for (const Field& field : world_->desc().fields) {
    if (const auto* well = std::get_if<WellField>(&field)) places.push_back(well->position);
  }
  wells_ = std::make_shared<const std::vector<Vec2>>(std::move(places));
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
