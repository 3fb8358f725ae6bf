// A bridge that breaks: crates, each twice as heavy, fall on planks on pins until a pin bears too much. Exits with 1 if the
// bridge does not carry the first crates, or does not break under the last.
#include <psim/psim.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr int kPlanks = 20;           // of 1 m
constexpr double kPlankMass = 50;     // kg
constexpr double kStrength = 60'000;  // N: of the pin in the middle; the others bear more

}  // namespace

int main() {
  std::string error;
  const auto world = psim::World::create({.linear_damping = 0.5}, {}, error);
  if (!world) return std::fprintf(stderr, "%s\n", error.c_str()), 1;

  psim::JointDesc pin;
  pin.type = psim::JointType::revolute;
  pin.a = psim::kWorldBody;  // anchors at the world are points of the world
  pin.anchor_a = {0, 0};
  pin.anchor_b = {-0.5, 0};
  psim::JointId pins[kPlanks + 1];
  psim::Vec2 end{0, 0};
  for (int k = 0; k <= kPlanks; ++k) {
    // Planks hang in an arc. Without slack the bridge would pull at its ends with any force.
    const double angle = 0.04 * (k - 0.5 * (kPlanks - 1));
    const psim::Vec2 half{0.5 * std::cos(angle), 0.5 * std::sin(angle)};
    if (k < kPlanks) {
      pin.b = world->add_body({.shape = psim::BoxShape{1, 0.2},
                               .position = {end.x + half.x, end.y + half.y},
                               .angle = angle,
                               .material = {.friction = 0.6},
                               .mass = kPlankMass},
                              error);
    } else {
      pin.b = psim::kWorldBody;
      pin.anchor_b = end;
    }
    pin.break_force = kStrength * (1 + 0.2 * std::abs(k - kPlanks / 2));
    pin.user_data = static_cast<std::uint64_t>(k);  // comes back when the pin breaks
    pins[k] = world->add_joint(pin, error);
    pin.a = pin.b;
    pin.anchor_a = {0.5, 0};
    end = {end.x + 2 * half.x, end.y + 2 * half.y};
  }

  int held = 0, broken = 0;
  psim::BodyId crate;
  for (double mass = 25; mass <= 3200; mass *= 2) {
    world->remove_body(crate);
    crate = world->add_body(
        {.shape = psim::BoxShape{1, 1}, .position = {end.x / 2, 0}, .material = {.friction = 0.6}, .mass = mass},
        error);
    for (int frame = 0; frame < 600; ++frame) {
      world->step();
      for (const psim::JointBreak& b : world->events().breaks) {
        ++broken;
        std::printf("%.0f kg: pin %d breaks with %.1f kN\n", mass, static_cast<int>(b.user_data),
                    std::hypot(b.force.x, b.force.y) / 1000);
      }
    }
    if (broken > 0) break;
    const psim::JointState left = *world->joint(pins[0]), right = *world->joint(pins[kPlanks]);
    const double ends = left.force.y - right.force.y;  // forces are on b: a plank at the left, the world at the right
    const double weight = -world->desc().gravity.y * (kPlanks * kPlankMass + mass);
    std::printf("%.0f kg: the ends carry %.2f kN of %.2f kN\n", mass, ends / 1000, weight / 1000);
    if (std::fabs(ends - weight) < 0.02 * weight) ++held;  // it still swings a little
  }
  const double y = world->body(crate)->y;
  std::printf("the crate is at y = %.0f m, %zu of %d pins are left\n", y, world->joint_count(), kPlanks + 1);
  return held >= 2 && broken > 0 && y < -10 ? 0 : 1;
}
