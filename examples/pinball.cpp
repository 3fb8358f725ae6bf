// Pinball: flippers are motors on pins with limits, bumpers kick and score by hit events, the ball is a bullet. A script
// plays nine balls. Exits with 1 if the ball leaves the table, a flipper passes its limits, or no bumper is hit.
#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace {

constexpr double kLimit = 0.5, kMotorSpeed = 20, kMotorTorque = 4;  // of a flipper: rad, rad/s, N m

psim::BodyId add(psim::World& world, const psim::Shape& shape, psim::Vec2 at, int points, double mass) {
  psim::BodyDesc body;
  body.type = mass > 0 ? psim::BodyType::dynamic_body : psim::BodyType::static_body;
  body.shape = shape;
  body.position = at;
  body.mass = mass;
  body.material.restitution = points > 0 ? 1 : 0.3;
  body.filter.group = -1;  // all but the ball: flippers pass through what they hang on
  body.user_data = static_cast<std::uint64_t>(points);
  std::string error;
  return world.add_body(body, error);
}

}  // namespace

int main() {
  std::string error;
  const auto world = psim::World::create({.gravity = {0, -2}, .substeps = 8}, {}, error);  // tilted by 12 degrees
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  add(*world, psim::ChainShape{{{-0.5, 0}, {0.5, 0}, {0.5, 1.7}, {0, 2}, {-0.5, 1.7}}, true}, {}, 0, 0);
  for (const double x : {-0.2, 0.0, 0.2}) add(*world, psim::DiscShape{0.07}, {x, x == 0 ? 1.45 : 1.1}, 100, 0);
  constexpr double kSides[] = {-1, 1};
  psim::JointId flippers[2];
  psim::JointDesc pin{.type = psim::JointType::revolute, .a = psim::kWorldBody, .lower = -kLimit, .upper = kLimit};
  for (int k = 0; k < 2; ++k) {
    add(*world, psim::SegmentShape{{0.5 * kSides[k], 0.5}, {0.2 * kSides[k], 0.3}}, {}, 0, 0);
    pin.anchor_a = {0.2 * kSides[k], 0.28};
    pin.b = add(*world, psim::CapsuleShape{{}, {-0.15 * kSides[k], 0}, 0.015}, pin.anchor_a, 0, 0.2);
    flippers[k] = world->add_joint(pin, error);
  }
  const psim::BodyId ball =
      world->add_body({.shape = psim::DiscShape{0.03}, .position = {0, 0.03}, .mass = 0.08, .bullet = true}, error);
  world->set_event_options({.hits = true, .hit_speed = 0.1});

  int balls = 0, score = 0;
  double past = 0;
  bool inside = true;
  for (int frame = 0; balls <= 9 && frame < 60 * 300; ++frame) {
    const psim::BodyState b = *world->body(ball);
    inside = inside && std::fabs(b.x) < 0.5 && b.y > 0 && b.y < 2;
    if (b.y < 0.1) {  // lost, or not yet played
      if (balls++ > 0) std::printf("ball %d is lost after %.1f s, score %d\n", balls - 1, frame / 60.0, score);
      world->set_transform(ball, {0.45, 0.6}, 0);
      world->set_velocity(ball, {-0.2, 3 + 0.1 * (balls % 4)}, 0);
    }
    for (int k = 0; k < 2; ++k) {  // the player hammers on the button while the ball is near
      const double from_middle = b.x * kSides[k];
      const bool pressed = from_middle > 0 && from_middle < 0.16 && b.y < 0.36 && frame % 24 < 12;
      world->set_motor(flippers[k], (pressed ? -kMotorSpeed : kMotorSpeed) * kSides[k], kMotorTorque);
      past = std::max(past, std::fabs(world->joint(flippers[k])->value) - kLimit);
    }
    world->step();
    psim::Vec2 kick;  // N s, applied after the loop: events are valid until the world changes
    for (const psim::HitEvent& hit : world->events().hits) {
      const auto points = static_cast<int>(world->user_data(hit.a == ball ? hit.b : hit.a));
      score += points;
      const double away = points == 0 ? 0 : hit.a == ball ? -0.08 : 0.08;
      kick = {kick.x + away * hit.normal.x, kick.y + away * hit.normal.y};
    }
    world->apply_impulse(ball, kick);
  }
  std::printf("the flippers passed their limits by %.4f rad\n", past);
  const double turn = kMotorSpeed * world->desc().dt / world->desc().substeps;  // in a substep
  return inside && score > 0 && past < turn ? 0 : 1;
}
