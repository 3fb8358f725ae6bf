// A car drives over hills: the road is a chain, the wheels hang on springs, the rear wheel has a motor. Exits with 1 if
// the car does not reach the goal, a spring goes past its end, or a wheel leaves its axis.
#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace {

constexpr double kGoal = 150;    // m
constexpr double kTravel = 0.2;  // m: a wheel moves as far up and down

double height_of_road(double x) { return x < 5 ? 0 : 2 * (1 - std::cos(0.15 * (x - 5))) + 0.05 * std::sin(x - 5); }

// Hangs a wheel below the chassis, whose middle is at `at`.
psim::JointId add_wheel(psim::World& world, psim::BodyId chassis, psim::Vec2 at, double offset, double torque) {
  std::string error;
  const psim::Vec2 hub{offset, -0.6};  // in the frame of the chassis
  const psim::BodyId wheel = world.add_body({.shape = psim::DiscShape{0.4},
                                             .position = {at.x + hub.x, at.y + hub.y},
                                             .material = {.friction = 0.9},
                                             .mass = 25},
                                            error);
  psim::JointDesc joint;
  joint.type = psim::JointType::wheel;
  joint.a = chassis;
  joint.b = wheel;
  joint.anchor_a = hub;
  joint.axis = {0, 1};
  joint.stiffness = 50'000;  // N/m
  joint.damping = 4'000;     // N s/m
  joint.lower = -kTravel;
  joint.upper = kTravel;
  joint.motor_speed = -25;  // rad/s: clockwise, 10 m/s on the road
  joint.motor_limit = torque;
  return world.add_joint(joint, error);
}

}  // namespace

int main() {
  std::string error;
  const auto world = psim::World::create({}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::ChainShape road;
  for (int x = -20; x <= 200; ++x) road.vertices.push_back({1.0 * x, height_of_road(x)});
  world->add_body({.type = psim::BodyType::static_body, .shape = road, .material = {.friction = 0.9}}, error);

  const psim::PolygonShape body{{{-1.6, -0.4}, {1.6, -0.4}, {1.6, 0}, {0.4, 0.7}, {-1.2, 0.7}, {-1.6, 0.1}}};
  const psim::Vec2 at{0, 1};
  const psim::BodyId chassis = world->add_body({.shape = body, .position = at, .mass = 700}, error);
  const psim::JointId springs[] = {add_wheel(*world, chassis, at, -1.1, 1'000), add_wheel(*world, chassis, at, 1.1, 0)};

  double compressed = 0, off_axis = 0, next_report = 30, x = 0;
  for (int frame = 1; frame <= 60 * 60 && x < kGoal; ++frame) {
    world->step();
    x = world->body(chassis)->x;
    for (const psim::JointId id : springs) {
      const psim::JointState s = *world->joint(id);  // `value`: how far the wheel is along its axis
      const double apart = std::hypot(s.anchor_b.x - s.anchor_a.x, s.anchor_b.y - s.anchor_a.y);
      compressed = std::max(compressed, std::fabs(s.value));
      off_axis = std::max(off_axis, apart - std::fabs(s.value));
    }
    if (x < next_report) continue;
    std::printf("%4.1f s: at (%.0f, %.1f) with %.1f m/s\n", frame / 60.0, x, world->body(chassis)->y,
                world->body(chassis)->vx);
    next_report += 30;
  }
  std::printf("the springs moved %.3f m, the wheels left their axis by %.1e m\n", compressed, off_axis);
  return x >= kGoal && compressed < kTravel + 1e-3 && off_axis < 1e-3 ? 0 : 1;
}
