// Cars seen from above, without gravity: a motor joint between the ground and a car is its engine, steering and tyres. Two
// cars drive the same figure of eight, one on a dry and one on a wet road. Exits with 1 if the dry one does not come back
// to where the figure began, the wet one does not drift, or tyres give more than their grip.
#include <psim/psim.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMass = 1000, kSpeed = 12, kSteer = 0.5;  // kg, m/s, rad/s

struct Car {
  const char* road;
  double grip;  // m/s^2: the largest acceleration that the tyres give
  double y;     // m: where it starts
  psim::JointId tyres = {};
  psim::BodyState now = {}, figure = {};  // figure: where the figure began
  double drift = 0, strain = 0;           // rad between nose and way; acceleration / grip: the most of both
};

// The driver wants to go where the nose points, and to turn. The joint gives what the tyres can.
void drive(psim::World& world, psim::JointId tyres, double speed, double steer) {
  psim::JointDesc joint = *world.joint_desc(tyres);
  const double nose = world.body(joint.b)->angle;
  joint.linear_velocity = {speed * std::cos(nose), speed * std::sin(nose)};
  joint.angular_velocity = steer;
  std::string error;
  world.set_joint(tyres, joint, error);
}

}  // namespace

int main() {
  std::string error;
  const auto world = psim::World::create({.gravity = {0, 0}}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  Car cars[] = {{"dry", 9, 100}, {"wet", 4, -100}};
  for (Car& car : cars) {
    psim::JointDesc tyres{.type = psim::JointType::motor, .a = psim::kWorldBody};
    tyres.b = world->add_body({.shape = psim::BoxShape{4, 2}, .position = {0, car.y}, .mass = kMass}, error);
    tyres.force_limit = kMass * car.grip;
    tyres.torque_limit = kMass * car.grip;
    car.tyres = world->add_joint(tyres, error);
    car.now = *world->body(tyres.b);
  }

  for (const double steer : {0.0, kSteer, -kSteer}) {  // straight on, a circle to the left, one to the right
    const int frames = steer == 0 ? 300 : static_cast<int>(std::lround(2 * kPi / kSteer * 60));
    for (int frame = 0; frame < frames; ++frame) {
      for (const Car& car : cars) drive(*world, car.tyres, kSpeed, steer);
      world->step();
      for (Car& car : cars) {
        const psim::BodyState before = std::exchange(car.now, *world->body(car.now.id));
        const double change = std::hypot(car.now.vx - before.vx, car.now.vy - before.vy);
        car.strain = std::max(car.strain, change / world->desc().dt / car.grip);
        const double way = std::atan2(car.now.vy, car.now.vx);
        car.drift = std::max(car.drift, std::fabs(std::remainder(way - car.now.angle, 2 * kPi)));
      }
    }
    for (Car& car : cars) {
      if (steer == 0) car.figure = car.now;
      std::printf("%s road: %.1f m from the crossing with %.1f m/s, drifted by up to %.1f degrees\n", car.road,
                  std::hypot(car.now.x - car.figure.x, car.now.y - car.figure.y), std::hypot(car.now.vx, car.now.vy),
                  car.drift * 180 / kPi);
    }
  }
  const Car &dry = cars[0], &wet = cars[1];
  std::printf("the tyres gave up to %.3f and %.3f of their grip\n", dry.strain, wet.strain);
  const bool back = std::hypot(dry.now.x - dry.figure.x, dry.now.y - dry.figure.y) < 0.5;
  return back && dry.drift < 0.02 && wet.drift > 0.5 && dry.strain < 1.001 && wet.strain < 1.001 ? 0 : 1;
}
